"""One proof over several processes: the same problem by one thread, and by `octmip.trees.cluster` with one and two.

Trees, bounds and evaluated cuts must be the same.
"""

import re
import time
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from benchmarks.data import published, uci
from benchmarks.tables import Line
from octmip.interfaces.report.markdown import markdown_table
from octmip.trees.cluster import open_cluster
from octmip.trees.methods.exact import branch_and_bound
from octmip.trees.methods.options import ExactOptions
from octmip.trees.problem import Problem
from octmip.trees.solution import Limits, Solution

CASES: tuple[tuple[str, int, float], ...] = (
    ("mu2", 3, 0.0),
    ("mu1", 4, 0.0),
    ("skin-segmentation", 4, 0.0),
    ("ct-magic", 3, 0.0),
    ("mu2", 4, 900.0),
)
"""Set, depth, and the limit in seconds from which on it is asked."""
NO_LIMITS = Limits()


SMALL = Problem(np.arange(40.0).reshape(20, 2) % 7, np.arange(20) % 2, depth=3)


def results(limit: float, threads: Sequence[int], only: str = "") -> Iterator[Line]:
    """Yield for each case and number of processes the measured times.

    `only` is a regular expression on "set, depth D".
    """
    for name, depth, least in CASES:
        size = f"{name}, depth {depth}"
        if not re.search(only, size) if only else limit < least:
            continue
        table = published(name, 0) if name.startswith("mu") else uci(name)
        problem = Problem(table.features, table.labels, depth=depth)
        alone, seconds = timed(problem, Limits(seconds=limit))
        case: Line = {"size": size, "seed": 0, "objective": alone.objective, "alone": seconds}
        for count in threads:
            yield case | _shared(problem, alone, count)


def _shared(problem: Problem, alone: Solution, count: int) -> Line:
    """Return what so many processes take, and whether their solution is that of one thread."""
    with open_cluster("local", count) as cluster:
        timed(SMALL, cluster=cluster)  # workers import what they need
        shared, wall = timed(problem, cluster=cluster)
    same = (shared.tree, shared.bound, shared.n_nodes) == (alone.tree, alone.bound, alone.n_nodes)
    return {"workers": count, "seconds": wall, "same": same}


def timed(problem: Problem, limits: Limits = NO_LIMITS, cluster: Any = None) -> tuple[Solution, float]:
    """Return the solution of a problem and the wall seconds that it took."""
    start = time.perf_counter()
    return branch_and_bound(problem, limits=limits, options=ExactOptions(cluster=cluster)), time.perf_counter() - start


def summary(lines: Sequence[Line]) -> str:
    """Return the measured table."""
    return markdown_table(
        [
            {
                "case": line["size"],
                "processes": line["workers"],
                "wall s": round(line["seconds"], 2),
                "one thread, wall s": round(line["alone"], 2),
                "same tree, bound, cuts": "yes" if line["same"] else "NO",
            }
            for line in lines
        ]
    )
