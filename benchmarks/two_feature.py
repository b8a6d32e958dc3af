"""What the families of two-feature cases share: rows of the published strains, and one measured and certified run."""

import resource
import time
from typing import Any

import numpy as np

from benchmarks.data import Table, published
from octmip.certificate import certify
from octmip.oblique import two_feature_branch_and_bound
from octmip.problem import Problem
from octmip.solution import Limits


def strains(target: str, n_samples: int, n_gauges: int) -> Table:
    """Return so many rows and the first gauges of the published strains."""
    table = published(target, 0)
    rows = np.random.default_rng(n_samples).permutation(len(table.labels))[:n_samples]
    rows = rows if n_samples < len(table.labels) else np.arange(n_samples)
    return Table(table.features[rows, :n_gauges], table.labels[rows])


def measure(problem: Problem, limit: float, n_threads: int) -> dict[str, Any]:
    """Solve, certify, and return the figures of one result line."""
    before, start = resource.getrusage(resource.RUSAGE_SELF), time.perf_counter()
    solution = two_feature_branch_and_bound(problem, limits=Limits(seconds=limit), n_jobs=n_threads)
    wall = time.perf_counter() - start
    after = resource.getrusage(resource.RUSAGE_SELF)
    certify(problem, solution)
    return {
        "objective": solution.objective,
        "bound": solution.bound,
        "outcome": "proven" if solution.is_optimal else f"not proven ({solution.stop})",
        "n_nodes": solution.n_nodes,
        "cpu_seconds": round(after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime, 3),
        "wall_seconds": round(wall, 3),
    }
