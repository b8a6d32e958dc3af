"""Enumeration of trees that survive drift."""
