"""Shell elements: stiffness, mass and strain rows in global axes, one file an element."""
