"""Costs of single samples against enumeration: `python -m benchmarks.run fuzz_sample_costs`, 1,000 small problems.

Of every problem the exact core over weighted rows; of every fiftieth also local search, CART, OCT over the rows, and
OCT's own model in whose rows each sample has its prices. Costs are whole, decimal, real, or span twelve orders; some
decisions are nobody's best.
"""

from collections.abc import Iterator

import numpy as np

from benchmarks.cpu import Stopwatch
from benchmarks.oracles.enumeration import optimum
from benchmarks.outside import BY_PYOMO
from benchmarks.problem_options import ProblemOptions
from benchmarks.tables import Line
from octmip.trees.certificate import certify
from octmip.trees.losses import ClassCosts
from octmip.trees.mip.pyomo_model import model, solution_of
from octmip.trees.problem import Problem
from octmip.trees.solution import Limits, Solution
from octmip.trees.solver import Method, solve

COUNT, FIRST_SEED, CHUNK = 1_000, 70_000, 50
SECONDS = 10.0
"""Of one method."""
EVERY = 50
"""One problem in so many is answered by every method."""
ROUNDING = 1e-12


def sample_problem(rng: np.random.Generator) -> Problem:
    """Return a random problem of two to four decisions, whose costs are those of single samples."""
    n, k = int(rng.integers(2, 11)), int(rng.integers(2, 5))
    kinds = (rng.integers(0, 6, (n, k)), rng.integers(0, 100, (n, k)) / 10, rng.random((n, k)))
    costs = (*kinds, 10.0 ** rng.uniform(-6, 6, (n, k)))[int(rng.integers(4))]
    options: ProblemOptions = {"depth": int(rng.integers(1, 4)), "class_names": tuple(range(k))}
    if rng.random() < 0.3:
        options["weights"] = rng.random(n) + 0.01
    if rng.random() < 0.3:
        options["leaf_penalty"] = float(rng.choice([0.5, 1.0, 0.3]))
    if k == 2 and rng.random() < 0.5:
        options["leaf_size"] = int(rng.integers(1, min(n, 3) + 1))
    features = rng.integers(0, 5, (n, 2)).astype(float)
    options["loss"] = ClassCosts(costs, per_sample=True)
    return Problem(features, costs.argmin(axis=1), **options)


def answers(problem: Problem, *, by_all: bool) -> dict[str, Solution]:
    """Return certified solutions by the exact core, or by every method and OCT's own model."""
    names: tuple[Method, ...] = ("exact", "cart", "search", "oct", "benders") if by_all else ("exact",)
    found: dict[str, Solution] = {str(name): solve(problem, name, Limits(SECONDS)) for name in names}
    if by_all:
        M = model(problem, "oct")
        found["model"] = solution_of(M, BY_PYOMO["HiGHS"](M, SECONDS))
    for solution in found.values():
        certify(problem, solution)
    return found


def faults(problem: Problem, found: dict[str, Solution]) -> list[str]:
    """Return what is wrong with some solutions by enumeration."""
    least = optimum(problem).objective
    within = ROUNDING * max(1.0, least)
    wrong = [f"{name}: bound {one.bound} above {least}" for name, one in found.items() if one.bound > least + within]
    claimed = {name: one for name, one in found.items() if one.is_optimal}
    return wrong + [
        f"{name}: {one.objective} is called optimal, {least} is"
        for name, one in claimed.items()
        if abs(one.objective - least) > within + one.tolerance
    ]


def results(limit: float, threads: list[int]) -> Iterator[Line]:
    """Yield a line for each chunk of problems."""
    for first in range(FIRST_SEED, FIRST_SEED + COUNT, CHUNK):
        watch, wrong, proven, n_called = Stopwatch(), [], 0, 0
        for seed in range(first, first + CHUNK):
            problem = sample_problem(np.random.default_rng(seed))
            found = answers(problem, by_all=seed % EVERY == 0)
            wrong += [f"seed {seed}: {fault}" for fault in faults(problem, found)]
            proven, n_called = proven + found["exact"].is_optimal, n_called + len(found)
        cpu, _ = watch.read()
        yield {
            "size": CHUNK,
            "seed": first,
            "calls": n_called,
            "proven": proven,
            "wrong": wrong,
            "cpu_seconds": round(cpu, 2),
        }


def summary(lines: list[Line]) -> str:
    """Return one line of counts, and what is wrong."""
    n, calls, proven = (sum(line[key] for line in lines) for key in ("size", "calls", "proven"))
    wrong = [fault for line in lines for fault in line["wrong"]]
    return "\n".join([f"{n} problems, {calls} calls, exact proves {proven}: {len(wrong)} wrong.", *wrong])
