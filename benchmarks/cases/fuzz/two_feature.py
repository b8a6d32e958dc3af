"""Two-feature trees against exhaustive enumeration on 2,000 random problems, depth 1 and 2."""

from collections.abc import Iterator, Sequence

import numpy as np

from benchmarks.oracles.two_feature import best_objective
from benchmarks.oracles.two_feature_problems import random_two_feature_problem
from benchmarks.tables import Line
from octmip.errors import OctmipError
from octmip.trees.certificate import certify
from octmip.trees.methods.two_feature import two_feature_branch_and_bound
from octmip.trees.problem import Problem

CHUNK = 250
STREAM = 60  # of seeds: problem i is random_two_feature_problem(default_rng([STREAM, i]))
MOST_SAMPLES = {1: 14, 2: 10}


def results(limit: float, threads: Sequence[int]) -> Iterator[Line]:
    """Yield a line for each chunk of 250 problems, four chunks per depth; `limit` has no effect."""
    for depth in (1, 2):
        for first in range(0, 4 * CHUNK, CHUNK):
            wrong = {}
            for seed in range(first, first + CHUNK):
                rng = np.random.default_rng([STREAM, depth, seed])
                problem = random_two_feature_problem(rng, depth=depth, max_samples=MOST_SAMPLES[depth])
                if reason := complaint(problem, max(threads)):
                    wrong[seed] = reason
            size = f"depth {depth}, seeds {first} to {first + CHUNK - 1}"
            yield {"size": size, "seed": STREAM, "n_problems": CHUNK, "mismatches": wrong}


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
