"""Regression trees against exhaustive enumeration on random problems: ties, weights, leaf sizes, penalties, budgets.

`python -m benchmarks.run fuzz_regression --limit 300 --threads 2`: 10,000 problems of each loss at least. Of every
fifth a proof log is written and checked, too, by two threads.
"""

import tempfile
import time
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from fractions import Fraction
from pathlib import Path

import numpy as np

from benchmarks.oracles.regression_trees import least_objective, random_problem
from benchmarks.tables import Line
from octmip.errors import OctmipError
from octmip.trees.certificate import certify
from octmip.trees.losses import SPELLINGS
from octmip.trees.methods.options import ExactOptions
from octmip.trees.problem import Problem
from octmip.trees.proof import check_proof
from octmip.trees.solution import Solution
from octmip.trees.solver import solve

CHUNK = 250
FEWEST = 10_000
LOGGED = 5
LOG_LOSS = 4e-6
"""Share of the baseline that the rounding of weights which are not dyadic may cost a log's bound: they are cut to 26
binary digits together, and a leaf's squares lose up to some of the last of them each."""
STREAM = 27  # of seeds: problem i of a loss is random_problem(default_rng([STREAM, i]), loss)


def results(limit: float, threads: Sequence[int]) -> Iterator[Line]:
    """Yield a line for each chunk until the time is up, but for `FEWEST` problems of each loss at least."""
    start = time.perf_counter()
    with ProcessPoolExecutor(max(threads)) as pool:
        first = 0
        while first < FEWEST or time.perf_counter() - start < limit:
            firsts = range(first, first + CHUNK * max(threads), CHUNK)
            yield from pool.map(
                _chunk,
                [f for f in firsts for _ in SPELLINGS],
                [loss for _ in firsts for loss in SPELLINGS],
            )
            first = firsts.stop


def _chunk(first: int, loss: str) -> Line:
    seeds = range(first, first + CHUNK)
    wrong = {seed: reason for seed in seeds if (reason := complaint(seed, loss))}
    size = f"{loss} error, seeds {first} to {seeds.stop - 1}"
    return {"size": size, "seed": STREAM, "n_problems": CHUNK, "mismatches": wrong}


def complaint(seed: int, loss: str) -> str | None:
    """Return what is wrong with the answer to a random problem, None when nothing is."""
    problem = random_problem(np.random.default_rng([STREAM, seed]), loss)
    least = least_objective(problem)
    try:
        solution = solve(problem)
        certify(problem, solution)
    except OctmipError as error:
        return f"{type(error).__name__}: {error}"
    assert solution.tree is not None
    if Fraction(solution.bound) > least:
        return f"bound {solution.bound} above {float(least)}"
    excess = float(problem.exact_objective(solution.tree) - least)
    if excess > 1e-12 * problem.baseline:
        return f"objective {solution.objective}, enumeration finds {float(least)}"
    if not solution.is_optimal:
        return f"stopped {solution.stop} with bound {solution.bound}"
    return None if seed % LOGGED else _complaint_of_log(problem, solution, least)


def _complaint_of_log(problem: Problem, solution: Solution, least: Fraction) -> str | None:
    """Return what is wrong with the proof log, or with the answer of two threads."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "proof.log"
        try:
            logged = solve(problem, n_jobs=2, options=ExactOptions(proof=path))
            proven = check_proof(problem, path, bound=logged.bound).bound
        except OctmipError as error:
            return f"with a log, {type(error).__name__}: {error}"
    if Fraction(proven) > least or proven < float(least) - LOG_LOSS * problem.baseline:
        return f"the log proves {proven}, enumeration finds {float(least)}"
    return None if logged.tree == solution.tree else "two threads find another tree"
