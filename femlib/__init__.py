"""Finite-element shells, damage components and the wing whose simulated strains the decision trees are trained on."""
