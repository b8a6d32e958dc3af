"""Problems that lack readings: the exact solver against enumeration that knows of no columns, and their proof logs.

`python -m benchmarks.run fuzz_missing --limit 300 --threads 2`: so many seconds in so many processes, a line per chunk.
"""

from collections.abc import Iterator, Sequence

import numpy as np

from benchmarks.exact_answers import CHUNK, chunks, complaint, summary
from benchmarks.oracles.strategies import random_problem, with_missing
from benchmarks.tables import Line
from octmip.trees.problem import Problem

__all__ = ["problem_with_missing", "results", "summary"]

STREAM = 70  # of seeds: problem i is drawn by default_rng([STREAM, i])


def problem_with_missing(seed: int) -> Problem:
    """Return a small random problem, most of them with readings missing."""
    rng = np.random.default_rng([STREAM, seed])
    return with_missing(rng, random_problem(rng))


def results(limit: float, threads: Sequence[int]) -> Iterator[Line]:
    """Yield a line for each chunk until the time is up, but for 1,000 problems at least."""
    yield from chunks(_chunk, limit, max(threads))


def _chunk(first: int) -> Line:
    seeds = range(first, first + CHUNK)
    problems = {seed: problem_with_missing(seed) for seed in seeds}
    wrong = {seed: reason for seed, problem in problems.items() if (reason := complaint(problem))}
    n_with_missing = sum(problem.n_missing > 0 for problem in problems.values())
    line = {"size": f"seeds {first} to {seeds.stop - 1}", "seed": STREAM, "n_problems": CHUNK}
    return line | {"with_missing": n_with_missing, "mismatches": wrong}
