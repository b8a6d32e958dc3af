"""Trees of any depth where splits have a price, beside imodels' FastSmallTreeClassifier: small public tables.

STreeD and TreeFARMS take part where a table has few thresholds. All answer in forks of this process: the peer is
compiled once, before the first clock, which takes longer than most cases.
"""

import math
from collections.abc import Iterator, Sequence
from functools import partial

from benchmarks.cpu import Stopwatch, within
from benchmarks.data import uci
from benchmarks.rivals import RIVALS, Answer, can_be_binary
from benchmarks.tables import Line, race_table
from octmip.trees.question.problem import Problem

OURS, PEER = "octmip", "fastsmalltree"
BINARY = ("pystreed", "treefarms")
MOST_WALL_SECONDS = 1e4
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
    "hayes-roth",
    "contraceptive-method-choice",
)
PRICES = (0.05, 0.02, 0.01, 0.005, 0.002)
"""Of a split, as shares of the samples."""


def results(limit: float, threads: Sequence[int]) -> Iterator[Line]:
    """Yield a line for each price, table and solver, stopped after `limit` CPU seconds.

    A solver that was stopped is not run on the same table at lower prices, which take longer.
    """
    RIVALS[OURS].prepare(_problem("iris", PRICES[0]))(limit, 1)  # imported before the first clock
    stopped: set[tuple[str, str]] = set()
    for price in PRICES:
        for name in TABLES:
            problem = _problem(name, price)
            for solver in (OURS, PEER, *(BINARY if can_be_binary(problem.samples.features) else ())):
                line = {"size": f"{name}, price {price:g}", "seed": 0, "solver": solver, "threads": 1, "limit": limit}
                if (name, solver) in stopped:
                    yield line | {"outcome": "not run: stopped at a higher price"}
                    continue
                measured = _measured(problem, solver, limit)
                if measured["outcome"] != "proven":
                    stopped.add((name, solver))
                yield line | measured


def _problem(name: str, price: float) -> Problem:
    table = uci(name)
    return Problem(table.features, table.labels, leaf_penalty=price * len(table.labels))


def _measured(problem: Problem, solver: str, limit: float) -> Line:
    rival = RIVALS[solver]
    fit = rival.prepare(problem)

    def work() -> tuple[Answer, tuple[float, float]]:
        watch = Stopwatch()
        return fit(MOST_WALL_SECONDS, 1), watch.read()

    found = within(limit, work)
    line = {"version": rival.version}
    if found is None:
        return line | {"outcome": "not proven", "objective": math.inf, "cpu_seconds": limit}
    answer, (cpu, wall) = found
    is_proven = answer.bound >= answer.objective - 1e-9 * max(1.0, answer.objective)
    return line | {
        "outcome": "proven" if is_proven else "not proven",
        "objective": round(answer.objective, 6),
        "cpu_seconds": round(cpu, 6),
        "wall_seconds": round(wall, 6),
        "settings": answer.settings,
    }


summary = partial(race_table, peer=PEER)
