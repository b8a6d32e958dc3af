"""Structures of the user's own beside another program."""
