"""A tree: its nodes, what they predict, and the order of their answers."""
