"""Composition root: services, command line and, later, the HTTP service and its page."""
