"""The exact solver against exhaustive enumeration on random problems full of what breaks solvers.

`python -m benchmarks.run fuzz_exact --limit 300 --threads 2`: so many seconds in so many processes, a line per chunk.
"""

from collections.abc import Iterator, Sequence

import numpy as np

from benchmarks.exact_answers import CHUNK, chunks, complaint, summary
from benchmarks.oracles.strategies import random_problem
from benchmarks.tables import Line

__all__ = ["complaint", "results", "summary"]

STREAM = 20  # of seeds: problem i is random_problem(default_rng([STREAM, i]))


def results(limit: float, threads: Sequence[int]) -> Iterator[Line]:
    """Yield a line for each chunk until the time is up, but for `FEWEST` problems at least."""
    yield from chunks(_chunk, limit, max(threads))


def _chunk(first: int) -> Line:
    seeds = range(first, first + CHUNK)
    wrong = {
        seed: reason for seed in seeds if (reason := complaint(random_problem(np.random.default_rng([STREAM, seed]))))
    }
    return {"size": f"seeds {first} to {seeds.stop - 1}", "seed": STREAM, "n_problems": CHUNK, "mismatches": wrong}
