"""Shared sensors: trees for several labels under one budget."""
