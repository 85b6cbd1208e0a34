"""What goes over the wire as JSON: one file for each resource."""
