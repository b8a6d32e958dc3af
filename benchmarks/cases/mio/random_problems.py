"""Benders = exact = enumeration on 200 random problems of depth 1 to 3.

They have weights, costs, leaf sizes, penalties, budgets and ties. The three programs share no line of their proofs. The
seeds are not those of the tests.
"""

from collections.abc import Iterator

import numpy as np

from benchmarks.cpu import Stopwatch
from benchmarks.oracles.enumeration import optimum
from benchmarks.oracles.strategies import random_problem
from benchmarks.tables import Line
from octmip.trees.certificate import certify
from octmip.trees.mip.benders.solver import solve_benders
from octmip.trees.mip.highs import highs
from octmip.trees.solution import Limits, Stop
from octmip.trees.solver import solve

COUNT, FIRST_SEED = 200, 90_000


def results(limit: float, threads: list[int]) -> Iterator[Line]:
    """Yield a line for each problem."""
    for seed in range(FIRST_SEED, FIRST_SEED + COUNT):
        problem = random_problem(np.random.default_rng(seed), max_samples=9, max_features=2)
        watch = Stopwatch()
        found = solve_benders(problem, limits=Limits(seconds=limit), n_jobs=threads[0])
        certify(problem, found)
        cpu, _ = watch.read()
        least = optimum(problem).objective
        exact = solve(problem, "exact").objective
        within = 1e-12 * max(1.0, least)
        yield {
            "size": repr(problem),
            "seed": seed,
            "threads": threads[0],
            "benders": found.objective,
            "bound": found.bound,
            "stop": str(found.stop),
            "exact": exact,
            "enumeration": least,
            "agree": bool(abs(found.objective - least) <= within and abs(exact - least) <= within),
            "proven": found.stop is Stop.OPTIMAL,
            "sound": bool(found.bound <= least + within),
            "cpu_seconds": round(cpu, 3),
            "version": f"HiGHS {highs.VERSION}",
        }


def summary(lines: list[Line]) -> str:
    """Return one line of counts, and the problems that are not as they ought to be."""
    counts = {key: sum(bool(line[key]) for line in lines) for key in ("agree", "proven", "sound")}
    good = ("agree", "proven", "sound")
    wrong = [f"seed {line['seed']}: {line}" for line in lines if not all(line[key] for key in good)]
    said = (
        f"{len(lines)} problems: one optimum in all three {counts['agree']}, proven by Benders {counts['proven']}, "
        f"bound sound {counts['sound']}; {sum(line['cpu_seconds'] for line in lines):.1f} CPU s."
    )
    return "\n".join([said, *wrong])
