"""The paper's complexity study: error of trees against depth and features a split, and what of it is overfitting."""
