"""What is asked: samples, loss, shape and parts of a tree, risk."""
