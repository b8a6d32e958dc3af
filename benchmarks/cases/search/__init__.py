"""Local search: how often the optimum is found, and how fast."""
