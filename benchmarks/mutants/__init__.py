"""Mutants: one wrong word at a time in a copy of the tree, drawn at random, to see whether the tests notice."""
