"""Cases about sets of near-optimal trees."""
