"""Regression trees: agreement with enumeration, and how long proofs take."""
