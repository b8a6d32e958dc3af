"""What is wrong with the exact solver's answer to a small problem, by enumeration; and many problems in chunks."""

import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor

from benchmarks.oracles.enumeration import optimum
from benchmarks.tables import Line
from octmip.errors import OctmipError
from octmip.trees.certificate import certify
from octmip.trees.methods.exact import branch_and_bound
from octmip.trees.problem import Problem
from octmip.trees.tree import Leaf

CHUNK = 250
FEWEST = 1_000


def chunks(chunk: Callable[[int], Line], limit: float, n_workers: int) -> Iterator[Line]:
    """Yield the line of each chunk of `CHUNK` seeds until the time is up, but for `FEWEST` seeds at least."""
    start = time.perf_counter()
    with ProcessPoolExecutor(n_workers) as pool:
        first = 0
        while first < FEWEST or time.perf_counter() - start < limit:
            firsts = range(first, first + CHUNK * n_workers, CHUNK)
            yield from pool.map(chunk, firsts)
            first = firsts.stop


def complaint(problem: Problem) -> str | None:
    """Return what is wrong with the exact solver's answer to a small problem, None when nothing is."""
    best = optimum(problem)
    try:
        solution = branch_and_bound(problem)
        certify(problem, solution)
    except OctmipError as error:
        return f"{type(error).__name__}: {error}"
    if not solution.is_optimal:
        return f"stopped {solution.stop} with bound {solution.bound} of {solution.objective}"
    if abs(solution.objective - best.objective) > 1e-9 * best.objective:  # no tolerance excuses more than rounding
        return f"objective {solution.objective}, enumeration finds {best.objective}"
    if not problem.has_integer_costs:
        return None
    tied = branch_and_bound(problem, break_ties=True)
    fewest = certify(problem, tied)
    if (fewest.objective, fewest.n_splits) != (best.objective, best.n_splits):
        return f"tie: {fewest.n_splits} splits, enumeration finds {best.n_splits}"
    n_sensors = len(problem.sensors_used(tied.tree or Leaf(0)))
    ties = tied.details["ties_broken"]
    assert isinstance(ties, Mapping)
    if ties["sensors"] == "fewest, proven" and n_sensors != best.n_sensors:
        return f"tie: {n_sensors} sensors, enumeration finds {best.n_sensors}"
    return None


def summary(lines: Sequence[Line]) -> str:
    """Return how many problems were compared, and the mismatches."""
    wrong = [f"seed {seed}: {reason}" for line in lines for seed, reason in line["mismatches"].items()]
    n_problems = sum(line["n_problems"] for line in lines)
    return "\n".join([f"{n_problems} problems compared with enumeration, {len(wrong)} mismatches.", *wrong[:20]])
