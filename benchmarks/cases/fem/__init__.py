"""Finite elements, the reduced model and datasets."""
