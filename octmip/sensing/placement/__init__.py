"""Placement: which sensors to install for one label."""
