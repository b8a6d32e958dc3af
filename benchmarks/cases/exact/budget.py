"""Exact trees under a sensor budget: the published strains, depth 3, at most 1 to 5 of 20 gauges."""

from collections.abc import Iterator
from functools import partial

from benchmarks.case import Case
from benchmarks.data import published
from benchmarks.tables import race_table
from octmip.trees.problem import Problem


def cases() -> Iterator[Case]:
    """Yield a case for each target and budget."""
    for target in ("mu1", "mu2"):
        for budget in range(1, 6):
            size = f"published strains, {target}, depth 3, {budget} of 20 gauges"
            yield Case(size, 0, partial(_problem, target, budget), ("octmip",))


def _problem(target: str, budget: int) -> Problem:
    table = published(target, 0)
    return Problem(table.features, table.labels, depth=3, sensor_budget=budget)


summary = race_table
