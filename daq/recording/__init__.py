"""Recordings: the crash-safe journal, the Parquet file made of it, and the data structure read back."""
