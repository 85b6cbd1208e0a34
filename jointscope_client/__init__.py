"""Python client of the Jointscope service: `client.Client`, or `async_client.AsyncClient`; see docs/client.md."""
