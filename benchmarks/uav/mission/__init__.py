"""The mission: the self-aware aircraft among three obstacles, its policies, its watch and its forecast."""
