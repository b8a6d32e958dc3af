"""What an order along the gauges costs: the published strains, free and with every telling gauge monotone.

A gauge is telling where its correlation with the label is above 0.3 in size; the tree keeps the sign. New rows are the
readings of another seed.
"""

import time
from collections.abc import Iterator, Sequence

import numpy as np

from benchmarks.data import Table, published
from benchmarks.tables import Line, markdown
from octmip import Limits, Problem, predict, solve

SEED, NEW = 0, 1
TELLING = 0.3
"""Least size of a correlation with the label whose sign the tree must keep."""


def results(limit: float, threads: Sequence[int]) -> Iterator[Line]:
    """Yield a line for each label, depth and kind of tree."""
    for label in ("mu1", "mu2"):
        table, new = published(label, SEED), published(label, NEW)
        for depth in (2, 3):
            for name, monotone in (("free", None), ("in order", directions(table))):
                for n_threads in threads:
                    problem = Problem(table.features, table.labels, depth=depth, monotone=monotone)
                    yield {"label": label, "depth": depth, "tree": name} | _line(problem, new, limit, n_threads)


def directions(table: Table) -> list[int]:
    """Return the sign of each gauge's correlation with the label, 0 where it is not telling."""
    found = [float(np.corrcoef(column, table.labels)[0, 1]) for column in table.features.T]
    return [int(np.sign(one)) if abs(one) > TELLING else 0 for one in found]


def _line(problem: Problem, new: Table, limit: float, n_threads: int) -> Line:
    cpu = time.process_time()
    solution = solve(problem, "exact", limits=Limits(seconds=limit), n_jobs=n_threads)
    seconds = time.process_time() - cpu
    assert solution.tree is not None  # CART's at least
    called = np.array(problem.class_names)[predict(solution.tree, new.features)]
    return {
        "threads": n_threads,
        "errors": solution.objective,
        "bound": solution.bound,
        "is_proven": solution.is_optimal,
        "new_errors": int((called != new.labels).sum()),
        "n_new": len(new.labels),
        "cpu_seconds": round(seconds, 3),
    }


def summary(lines: list[Line]) -> str:
    """Return the table of docs/sensing.md."""
    keys = ("label", "depth", "tree", "errors", "bound", "new_errors", "cpu_seconds")
    head = ("label", "depth", "tree", "errors", "bound", "wrong on new rows", "CPU s")
    values = ([line[key] for key in keys] for line in lines)
    return markdown(head, ([f"{one:g}" if isinstance(one, float) else one for one in row] for row in values))
