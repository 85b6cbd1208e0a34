"""Which experiment would settle what a search has left open."""
