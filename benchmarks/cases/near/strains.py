"""All trees near the optimum of the published strains, and what each of the 20 gauges is worth: 1750 samples."""

import time
from collections.abc import Iterator, Sequence

from benchmarks.data import published
from benchmarks.tables import Line
from octmip.trees.near_sets import Role, near_optimal, sensor_roles
from octmip.trees.problem import Problem
from octmip.trees.solution import Limits

SEED = 0


def results(limit: float, threads: Sequence[int]) -> Iterator[Line]:
    """Yield a line for each label and question, depth 3, trees within 1 % of the optimum."""
    for label in ("mu1", "mu2"):
        table = published(label, SEED)
        problem = Problem(table.features, table.labels, depth=3)
        for n_threads in threads:
            yield _set(label, problem, limit, n_threads)
            yield _roles(label, problem, limit, n_threads)


def _set(label: str, problem: Problem, limit: float, n_threads: int) -> Line:
    wall, cpu = time.perf_counter(), time.process_time()
    found = near_optimal(problem, relative=0.01, limits=Limits(seconds=limit), n_jobs=n_threads)
    return {
        "size": f"{label}, trees within 1 %",
        "seed": SEED,
        "threads": n_threads,
        "objective": None if found.optimum is None else float(found.optimum),
        "trees": found.trees,
        "trees_at_least": found.trees_at_least,
        "seconds": time.perf_counter() - wall,
        "cpu_seconds": time.process_time() - cpu,
    }


def _roles(label: str, problem: Problem, limit: float, n_threads: int) -> Line:
    wall, cpu = time.perf_counter(), time.process_time()
    found = sensor_roles(problem, limits=Limits(seconds=limit), n_jobs=n_threads)
    counts = {str(role): sum(entry.role is role for entry in found.roles) for role in Role}
    return {
        "size": f"{label}, worth of each gauge",
        "seed": SEED,
        "threads": n_threads,
        "objective": found.solution.objective,
        "is_proven": found.is_proven,
        **counts,
        "seconds": time.perf_counter() - wall,
        "cpu_seconds": time.process_time() - cpu,
    }
