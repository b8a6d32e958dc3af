"""Logic-based Benders decomposition: a master over the split of a node, the trees below it as subproblems."""
