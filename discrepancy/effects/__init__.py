"""The catalogue: one file per effect, listed in one literal table."""
