"""Risk and uncertainty on the wing: what fearing to miss a critical damage costs, and how far leaves can be trusted."""
