"""The exact solver against exhaustive enumeration on random problems full of what breaks solvers.

One in ten is large in one way (`sized_problem`), beyond every constant of the core, and is enumerated in fractions.

`python -m benchmarks.run fuzz_exact --limit 300 --threads 2`: so many seconds in so many processes, a line per chunk.
"""

from collections.abc import Iterator, Sequence

import numpy as np

from benchmarks.exact_answers import CHUNK, chunks, complaint, summary
from benchmarks.kinds import classes
from benchmarks.oracles.rational import least_cost
from benchmarks.oracles.strategies import random_problem
from benchmarks.oracles.wide_problems import sized_problem
from benchmarks.tables import Line
from octmip.errors import OctmipError
from octmip.trees.methods.exact import branch_and_bound

__all__ = ["complaint", "results", "summary"]

STREAM = 20  # of seeds: problem i is drawn from default_rng([STREAM, i])
SIZED_ONE_IN = 10


def results(limit: float, threads: Sequence[int]) -> Iterator[Line]:
    """Yield a line for each chunk until the time is up, but for `FEWEST` problems at least."""
    yield from chunks(_chunk, limit, max(threads))


def _chunk(first: int) -> Line:
    seeds = range(first, first + CHUNK)
    wrong = {seed: reason for seed in seeds if (reason := _complaint(seed))}
    return {"size": f"seeds {first} to {seeds.stop - 1}", "seed": STREAM, "n_problems": CHUNK, "mismatches": wrong}


def _complaint(seed: int) -> str | None:
    rng = np.random.default_rng([STREAM, seed])
    if seed % SIZED_ONE_IN:
        return complaint(random_problem(rng))
    problem = sized_problem(rng)
    try:
        return classes.complaint(problem, branch_and_bound(problem), least_cost(problem)) or None
    except OctmipError as error:
        return f"{type(error).__name__}: {error}"
