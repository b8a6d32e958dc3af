"""The paper's complexity study: error of trees against depth and features per split, and its part by overfitting."""
