"""Device time against host time."""
