"""Examples of whole bodies for the OpenAPI document."""
