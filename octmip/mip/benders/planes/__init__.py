"""Combinatorial Benders for hyperplanes of few features: the root's line as a master, the lines below it as cuts."""
