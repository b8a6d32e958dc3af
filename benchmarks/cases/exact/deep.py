"""Trees of depth 5 within a time limit, beside solvers that improve a tree until their time is up.

STreeD takes no part: each of these tables has over a thousand thresholds. Times are wall seconds, as the solvers count
them, on one thread: the machine has to be idle.
"""

from collections.abc import Iterator, Sequence
from functools import partial

import numpy as np

from benchmarks.case import Case
from benchmarks.data import Table, uci
from benchmarks.tables import Line, markdown
from octmip.trees.question.problem import Problem

DEPTH = 5
TABLES = ("pima-diabetes", "winequality-white", "spambase", "ct-magic", "waveform")
SOLVERS = ("octmip-auto", "octmip-search", "pycontree", "pytrees-rs", "CART")


def cases() -> Iterator[Case]:
    """Yield a case for each table."""
    for name in TABLES:
        yield Case(name, 0, partial(_problem, name), SOLVERS)


def summary(lines: Sequence[Line]) -> str:
    """Return the errors of each solver that ran, and the bound of the proof."""
    found: dict[str, dict[str, Line]] = {}
    for line in lines:
        found.setdefault(line["size"], {})[line["solver"]] = line
    rows = []
    for name, by in found.items():
        errors = [f"{by[one]['objective']:g}" if "objective" in by.get(one, {}) else "" for one in SOLVERS]
        rows.append([name, next(iter(by.values()))["limit"], *errors, by.get(SOLVERS[0], {}).get("bound", "")])
    return markdown(["table", "seconds", *SOLVERS, "bound"], rows)


def _problem(name: str) -> Problem:
    table = _waveform() if name == "waveform" else uci(name)
    return Problem(table.features, table.labels, depth=DEPTH)


def _waveform(n: int = 5000) -> Table:
    """Return the waves of Breiman, Friedman, Olshen & Stone (1984), Classification and Regression Trees, 2.6.2."""
    rng, place = np.random.default_rng(0), np.arange(1, 22)
    waves = np.array([np.maximum(6 - np.abs(place - middle), 0) for middle in (7, 15, 11)])
    label, share = rng.integers(3, size=n), rng.uniform(size=(n, 1))
    first, second = waves[np.array([0, 0, 1])[label]], waves[np.array([1, 2, 2])[label]]
    return Table(share * first + (1 - share) * second + rng.normal(size=(n, 21)), label)
