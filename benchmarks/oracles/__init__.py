"""Independent answers that solvers and proofs are held against: short, slow and exact; imported by benchmarks and tests."""
