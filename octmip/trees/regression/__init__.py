"""Regression trees: numbers in the leaves, squared or absolute error, with the proof where splits read one feature."""
