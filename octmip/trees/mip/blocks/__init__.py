"""Blocks: families of columns and rows that the formulations are put together from."""
