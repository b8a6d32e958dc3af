"""Proof logs: of whom they are, and the program that reads them."""
