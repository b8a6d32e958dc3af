"""Proofs over splits of two features."""
