"""Twins made of other twins: one that keeps its answers, one with effects added."""
