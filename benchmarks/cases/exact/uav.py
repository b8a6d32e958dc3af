"""Exact axis-aligned trees on 20 strain gauges: the synthetic UAV sets and the published strains (three seeds)."""

from collections.abc import Iterator
from functools import partial

from benchmarks.case import Case
from benchmarks.data import published, synthetic_uav
from benchmarks.tables import race_table
from octmip.trees.question.problem import Problem

SEEDS = (0, 1, 2)
SOLVERS = ("octmip", "octmip-core", "pycontree")


def cases() -> Iterator[Case]:
    """Yield a case for each set, seed and depth."""
    for depth in (2, 3, 4):
        for target in ("A", "B"):
            yield Case(f"synthetic UAV {target}, depth {depth}", 0, partial(_synthetic, target, depth), SOLVERS)
        for target in ("mu1", "mu2"):
            for seed in SEEDS:
                size = f"published strains, {target}, depth {depth}"
                yield Case(size, seed, partial(_published, target, seed, depth), SOLVERS)


def _synthetic(target: str, depth: int) -> Problem:
    table = synthetic_uav(target)
    return Problem(table.features, table.labels, depth=depth)


def _published(target: str, seed: int, depth: int) -> Problem:
    table = published(target, seed)
    return Problem(table.features, table.labels, depth=depth)


summary = race_table
