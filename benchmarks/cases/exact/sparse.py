"""Trees of any depth where splits have a price, beside imodels' FastSmallTreeClassifier: small public tables.

Both answer in this process: the peer is compiled once, before the first clock, which takes longer than most cases.
"""

from collections.abc import Iterator, Sequence
from functools import partial

from benchmarks.cpu import Stopwatch
from benchmarks.data import uci
from benchmarks.rivals import RIVALS
from benchmarks.tables import Line, race_table
from octmip.trees.problem import Problem

OURS, PEER = "octmip", "fastsmalltree"
TABLES = (
    "iris",
    "wine",
    "seeds",
    "balance-scale",
    "teaching-assistant-evaluation",
    "banknote-authentication",
    "blood-transfusion",
    "vertebral-column-2c",
    "vertebral-column-3c",
    "parkinsons",
    "breast-cancer-wisconsin-diagnostic",
    "pima-diabetes",
)
PRICES = (0.05, 0.02, 0.01, 0.005, 0.002)
"""Of a split, as shares of the samples."""


def results(limit: float, threads: Sequence[int]) -> Iterator[Line]:
    """Yield a line for each price, table and solver, stopped by the clock."""
    _measured(_problem("iris", PRICES[0]), OURS, limit)  # imported before the first clock
    for price in PRICES:
        for name in TABLES:
            problem = _problem(name, price)
            for solver in (OURS, PEER):
                yield {"size": f"{name}, price {price:g}", "seed": 0, **_measured(problem, solver, limit)}


def _problem(name: str, price: float) -> Problem:
    table = uci(name)
    return Problem(table.features, table.labels, leaf_penalty=price * len(table.labels))


def _measured(problem: Problem, solver: str, limit: float) -> Line:
    rival = RIVALS[solver]
    fit = rival.prepare(problem)
    watch = Stopwatch()
    answer = fit(limit, 1)
    cpu, wall = watch.read()
    is_proven = answer.bound >= answer.objective - 1e-9 * max(1.0, answer.objective)
    return {
        "solver": solver,
        "threads": 1,
        "limit": limit,
        "outcome": "proven" if is_proven else "not proven",
        "objective": round(answer.objective, 6),
        "bound": round(answer.bound, 6),
        "cpu_seconds": round(cpu, 6),
        "wall_seconds": round(wall, 6),
        "version": rival.version,
        "settings": answer.settings,
    }


summary = partial(race_table, peer=PEER)
