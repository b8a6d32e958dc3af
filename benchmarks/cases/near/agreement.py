"""Sets of near-optimal trees against plain enumeration, on random problems full of what breaks solvers.

`python -m benchmarks.run near_agreement --limit 300 --threads 2`: so many seconds and processes, a line per chunk.
"""

import time
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor

import numpy as np

from benchmarks.oracles.strategies import random_problem, with_gaps
from benchmarks.tables import Line
from octmip.errors import OctmipError
from octmip.near_sets import near_optimal
from octmip.set_certificate import certify_set

CHUNK = 100
STREAM = 21  # of seeds: problem i is drawn from default_rng([STREAM, i])
SHARE_WITH_GAPS = 0.5
MARGINS = (0.0, 0.3, 0.5, 1.0, 2.0, 4.0)


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
    """Return what is wrong with the set of a random problem, None when nothing is."""
    problem = random_problem(rng, max_samples=int(rng.integers(4, 9)))
    if rng.random() < SHARE_WITH_GAPS:
        problem = with_gaps(rng, problem)
    try:
        found = near_optimal(problem, float(rng.choice(MARGINS)), by_sets=bool(rng.random() < 0.5))
        counted = certify_set(problem, found, found.best(5) + found.sample(3))
    except OctmipError as error:
        return f"{type(error).__name__}: {error}"
    if counted is None or not found.is_complete:
        return "the set was not counted, or not recounted"
    if dict(found.spectrum) != dict(counted.spectrum):
        return f"spectrum {found.spectrum}, enumeration finds {counted.spectrum}"
    if found.by_sensors is not None and dict(found.by_sensors) != dict(counted.by_sensors):
        return f"by sensors {found.by_sensors}, enumeration finds {counted.by_sensors}"
    return None
