"""Compiled equations of the emulated machine, one subject a file."""
