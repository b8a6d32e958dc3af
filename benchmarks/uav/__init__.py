"""The UAV study: how far heuristic trees are from the optimum on the wing's strains, and what no tree can know."""
