"""Sets of near-optimal trees against plain enumeration, on random problems full of what breaks solvers.

`python -m benchmarks.run near_agreement --limit 300 --threads 2`: so many seconds and processes, a line per chunk.
"""

from collections.abc import Iterator, Sequence

import numpy as np

from benchmarks.exact_answers import CHUNK, chunks
from benchmarks.oracles.strategies import random_problem, with_gaps
from benchmarks.tables import Line
from octmip.errors import OctmipError
from octmip.trees.near_sets import near_optimal
from octmip.trees.set_certificate import certify_set

STREAM = 21  # of seeds: problem i is drawn from default_rng([STREAM, i])
SHARE_WITH_GAPS = 0.5
MARGINS = (0.0, 0.3, 0.5, 1.0, 2.0, 4.0)


def results(limit: float, threads: Sequence[int]) -> Iterator[Line]:
    """Yield a line for each chunk until the time is up, but for 10,000 problems at least."""
    yield from chunks(_chunk, limit, max(threads))


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
