"""Octets in and out of a port: serial line, pseudo-terminal, TCP socket."""
