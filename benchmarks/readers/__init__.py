"""Readers of files under test: valid files, ways to mangle them, and a use of what is read."""
