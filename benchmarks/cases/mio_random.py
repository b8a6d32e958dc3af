"""One optimum from six programs on 200 random problems of depth 1 to 3.

The model in Pyomo under every solver outside that is installed, the rows on HiGHS as octmip drives it, Benders, the
exact core, and enumeration. Weights, costs, leaf sizes, penalties, budgets and ties are drawn; the seeds are not
those of the tests.
"""

from collections.abc import Iterator

import numpy as np

from benchmarks.cpu import Stopwatch
from benchmarks.outside import BY_PYOMO, DUAL_TOLERANCE, is_installed
from benchmarks.tables import Line
from octmip.errors import SolverError
from octmip.trees.answer.certificate import certify
from octmip.trees.answer.solution import Limits, Solution
from octmip.trees.mip.highs import highs
from octmip.trees.mip.pyomo_model import model, solution_of
from octmip.trees.question.problem import Problem
from octmip.trees.solver import solve
from tests.oracles.enumeration import optimum
from tests.oracles.strategies import random_problem

COUNT, FIRST_SEED = 200, 90_000
ROUNDING = 1e-12
"""Share of the optimum by which sums of float64 may differ."""


def results(limit: float, threads: list[int]) -> Iterator[Line]:
    """Yield a line for each problem."""
    for seed in range(FIRST_SEED, FIRST_SEED + COUNT):
        problem = random_problem(np.random.default_rng(seed), max_samples=9, max_features=2)
        watch = Stopwatch()
        found = {name: solve(problem, name, Limits(limit), n_jobs=threads[0]) for name in ("exact", "benders", "oct")}
        by_others, refused = by_pyomo(problem, limit)
        cpu, _ = watch.read()
        yield (
            {"size": repr(problem), "seed": seed, "threads": threads[0]}
            | judged(problem, found | by_others)
            | {
                "refused": refused,
                "cpu_seconds": round(cpu, 3),
                "version": f"HiGHS {highs.VERSION}",
            }
        )


def by_pyomo(problem: Problem, seconds: float) -> tuple[dict[str, Solution], dict[str, str]]:
    """Return the certified solution of OCT's model by each solver outside that is installed; why others are refused."""
    found, refused = {}, {}
    for solver in filter(is_installed, BY_PYOMO):
        M = model(problem, "oct")
        try:
            found[f"Pyomo, {solver}"] = solution_of(M, BY_PYOMO[solver](M, seconds), dual_tolerance=DUAL_TOLERANCE)
        except SolverError as error:
            refused[solver] = str(error)
    return found, refused


def judged(problem: Problem, found: dict[str, Solution]) -> Line:
    """Return who found the optimum of enumeration, who proved it, and whose bound lies above it."""
    least = optimum(problem).objective
    within = ROUNDING * max(1.0, least)
    for solution in found.values():
        certify(problem, solution)
    return {
        "enumeration": least,
        "by": list(found),
        "other": [name for name, one in found.items() if abs(one.objective - least) > within],
        "unproven": [name for name, one in found.items() if not one.is_optimal],
        "too_high": [name for name, one in found.items() if one.bound > least + within],
    }


def summary(lines: list[Line]) -> str:
    """Return one line of counts, and the problems that are not as they ought to be."""
    proven = {name: sum(name in set(line["by"]) - set(line["unproven"]) for line in lines) for name in lines[0]["by"]}
    n_other, n_high = (sum(bool(line[key]) for line in lines) for key in ("other", "too_high"))
    said = (
        f"{len(lines)} problems: {n_other} with another optimum in one of them, {n_high} with a bound too high; proven "
        f"by {', '.join(f'{name} {count}' for name, count in proven.items())}; "
        f"answers refused {sum(len(line['refused']) for line in lines)}; "
        f"{sum(line['cpu_seconds'] for line in lines):.1f} CPU s."
    )
    return "\n".join(
        [
            said,
            *(
                f"seed {line['seed']}: {line}"
                for line in lines
                if any(line[key] for key in ("other", "too_high", "refused"))
            ),
        ]
    )
