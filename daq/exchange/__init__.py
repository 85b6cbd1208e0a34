"""Recordings of others, brought in; ours, written out in the formats that others read."""
