"""Trees of least worst case against plain enumeration, on random problems full of what breaks solvers.

Three in ten have more cuts than the proof's 64 slices and 32 parts of the root, or more than 20 pairs of labels.

`python -m benchmarks.run fuzz_worst_case --limit 300 --threads 2`: so many seconds and processes, a line per chunk.
"""

import time
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor

import numpy as np

from benchmarks.kinds.others import WorstCases
from benchmarks.oracles.worst_case import least_worst_case
from benchmarks.tables import Line
from octmip.errors import OctmipError
from octmip.trees.worst_case import Bands, solve

CHUNK = 100
STREAM = 33  # of seeds: problem i is drawn from default_rng([STREAM, i])


def results(limit: float, threads: Sequence[int]) -> Iterator[Line]:
    """Yield a line for each chunk until the time is up."""
    start = time.perf_counter()
    with ProcessPoolExecutor(max(threads)) as pool:
        first, n_workers = 0, max(threads)
        while time.perf_counter() - start < limit:
            firsts = range(first, first + CHUNK * n_workers, CHUNK)
            yield from pool.map(_chunk, firsts)
            first = firsts.stop


def _chunk(first: int) -> Line:
    seeds = range(first, first + CHUNK)
    wrong = {seed: reason for seed in seeds if (reason := complaint(np.random.default_rng([STREAM, seed])))}
    return {"size": f"seeds {first} to {seeds.stop - 1}", "seed": STREAM, "n_problems": CHUNK, "mismatches": wrong}


def complaint(rng: np.random.Generator) -> str | None:
    """Return what is wrong with the answer to a random problem, None when nothing is."""
    drawn = WorstCases().draw(rng)
    problem, bands, off = drawn.problem, drawn.bands, drawn.off
    try:
        found = solve(problem, bands, off, n_jobs=int(rng.integers(1, 3)))
    except OctmipError as error:
        return f"{type(error).__name__}: {error}"
    best, own = least_worst_case(problem, Bands.of(problem, bands), off), found.solution.objective
    if not found.solution.is_optimal:
        return f"not proven: {own} with the bound {found.solution.bound}"
    if abs(best - own) > 1e-9 * max(1.0, best):
        return f"worst case {own}, enumeration finds {best}"
    return None
