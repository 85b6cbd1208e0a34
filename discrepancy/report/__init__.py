"""The self-contained report of one analysis."""
