"""Gaps of real data: demonstrations, not blind results."""
