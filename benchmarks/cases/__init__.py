"""Benchmark cases: one file a family, one line in `benchmarks.registry`."""
