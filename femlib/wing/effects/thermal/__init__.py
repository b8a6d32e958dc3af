"""Effects of temperature: the whole wing warmer, and one skin warmer than the other."""
