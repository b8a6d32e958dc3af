"""Local search: the share of searches that find the optimum, and their time."""
