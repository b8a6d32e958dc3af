"""Independent ways to know what an answer must be; tests and benchmarks both import them."""
