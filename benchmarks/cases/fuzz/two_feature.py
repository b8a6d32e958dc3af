"""Two-feature trees against exhaustive enumeration: 2,000 random problems, depth 1 and 2, and 200 of more points.

The 200 (`sized_lines`) have up to 60 points at depth 1 and 18 at depth 2: more than are parted one by one, more slopes
than bins, more crossings than are looked at.
"""

from collections.abc import Callable, Iterator, Sequence
from functools import partial

import numpy as np

from benchmarks.oracles.two_feature import best_objective
from benchmarks.oracles.two_feature_problems import random_two_feature_problem
from benchmarks.oracles.wide_problems import sized_lines
from benchmarks.tables import Line
from octmip.errors import OctmipError
from octmip.trees.certificate import certify
from octmip.trees.methods.two_feature import two_feature_branch_and_bound
from octmip.trees.problem import Problem

CHUNK = 250
STREAM = 60
N_SIZED = 200
MOST_SAMPLES = {1: 14, 2: 10}


def results(limit: float, threads: Sequence[int]) -> Iterator[Line]:
    """Yield a line for each chunk of 250 problems, four per depth, and one of larger ones; `limit` has no effect."""
    for depth in (1, 2):
        for first in range(0, 4 * CHUNK, CHUNK):
            yield _compared(f"depth {depth}", depth, _small(depth), range(first, first + CHUNK), max(threads))
    yield _compared("more points", 0, sized_lines, range(N_SIZED), max(threads))


def _small(depth: int) -> Callable[[np.random.Generator], Problem]:
    return partial(random_two_feature_problem, depth=depth, max_samples=MOST_SAMPLES[depth])


def _compared(
    name: str, stream: int, draw: Callable[[np.random.Generator], Problem], seeds: range, n_threads: int
) -> Line:
    drawn = ((seed, draw(np.random.default_rng([STREAM, stream, seed]))) for seed in seeds)
    wrong = {seed: reason for seed, problem in drawn if (reason := complaint(problem, n_threads))}
    size = f"{name}, seeds {seeds.start} to {seeds.stop - 1}"
    return {"size": size, "seed": STREAM, "n_problems": len(seeds), "mismatches": wrong}


def complaint(problem: Problem, n_threads: int) -> str | None:
    """Return what is wrong with the answer to a small problem, None when nothing is."""
    try:
        solution = two_feature_branch_and_bound(problem, n_jobs=n_threads)
        certify(problem, solution)
    except OctmipError as error:
        return f"{type(error).__name__}: {error}"
    best = best_objective(problem)
    if not solution.is_optimal:
        return f"stopped {solution.stop} with bound {solution.bound} of {solution.objective}"
    if abs(solution.objective - best) > solution.tolerance + 1e-12 * max(1.0, best):
        return f"objective {solution.objective}, enumeration finds {best}"
    return None


def summary(lines: Sequence[Line]) -> str:
    """Return how many problems were compared, and the mismatches."""
    wrong = [f"{line['size']}, {seed}: {reason}" for line in lines for seed, reason in line["mismatches"].items()]
    n_problems = sum(line["n_problems"] for line in lines)
    return "\n".join([f"{n_problems} problems compared with enumeration, {len(wrong)} mismatches.", *wrong[:20]])
