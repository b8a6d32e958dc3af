"""Readers of recordings, one file a format: `read(path)` returns a Recording."""
