"""Independent answers that solvers and proofs are held against, short, slow and exact; for benchmarks and tests."""
