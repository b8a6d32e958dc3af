"""Sweeps of the doors: inputs as other programs and instruments write them."""
