"""The store of recordings: a row for each, samples in files; upload, download, deletion with a period of grace."""
