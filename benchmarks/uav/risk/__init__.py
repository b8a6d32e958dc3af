"""Risk on the wing: what fearing to miss a critical damage costs."""
