"""Mutants: one wrong word at a time in a copy of the tree, to see whether the tests notice."""
