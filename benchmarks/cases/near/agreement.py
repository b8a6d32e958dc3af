"""Sets of near-optimal trees against plain enumeration, on random problems full of what breaks solvers.

One in five has up to 80 cuts, more than the 32 ranges above the limit.

`python -m benchmarks.run near_agreement --limit 300 --threads 2`: so many seconds and processes, a line per chunk.
"""

from collections.abc import Iterator, Sequence

import numpy as np

from benchmarks.exact_answers import CHUNK, chunks
from benchmarks.kinds.others import NearSets
from benchmarks.tables import Line
from octmip.errors import OctmipError
from octmip.trees.near_sets import near_optimal
from octmip.trees.set_certificate import certify_set

STREAM = 21  # of seeds: problem i is drawn from default_rng([STREAM, i])


def results(limit: float, threads: Sequence[int]) -> Iterator[Line]:
    """Yield a line for each chunk until the time is up, but for 1,000 problems at least."""
    yield from chunks(_chunk, limit, max(threads))


def _chunk(first: int) -> Line:
    seeds = range(first, first + CHUNK)
    wrong = {seed: reason for seed in seeds if (reason := complaint(np.random.default_rng([STREAM, seed])))}
    return {"size": f"seeds {first} to {seeds.stop - 1}", "seed": STREAM, "n_problems": CHUNK, "mismatches": wrong}


def complaint(rng: np.random.Generator) -> str | None:
    """Return what is wrong with the set of a random problem, None when nothing is."""
    drawn = NearSets().draw(rng)
    problem = drawn.problem
    try:
        found = near_optimal(problem, drawn.within, by_sets=drawn.by_sets)
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
