"""The mission: the self-aware aircraft among three obstacles, its policies, its watch, and a page that plays it."""
