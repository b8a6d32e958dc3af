"""Regression trees: enumeration and random problems, speed beside others, agreement."""
