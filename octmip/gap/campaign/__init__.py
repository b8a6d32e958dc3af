"""Measurements: a campaign of readings, its file, its plausibility, and the noise that its repeats show."""
