"""The host side of a rig: one thread that owns the port, and the calls that scripts and services make."""
