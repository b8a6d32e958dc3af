"""Enumeration of trees that survive reading errors."""
