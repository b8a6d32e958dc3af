"""The mixed-integer forms beside odtlearn's FlowOCT and BendersOCT on CBC, on problems of binary features.

Each feature becomes three binary ones, whether it is at most its first, second or third quartile: for all solvers the
same question. Every solver starts from what it starts from by itself (octmip: CART's tree).
"""

from collections.abc import Callable, Iterator
from functools import partial

import numpy as np

from benchmarks.case import Case
from benchmarks.data import Table, first_rows, published, uci
from benchmarks.tables import Line, race_table
from octmip.trees.problem import Problem

SOLVERS = ("octmip-benders", "octmip-flow2", "octmip-flow1", "octmip-oct", "odtlearn", "odtlearn-benders")


def cases() -> Iterator[Case]:
    """Yield the cases, small ones first."""
    tables: dict[str, Callable[[], Table]] = {
        "iris": partial(uci, "iris"),
        "wine": partial(uci, "wine"),
        "published mu1, 175 rows": partial(_rows, "mu1", 175),
        "published mu2, 175 rows": partial(_rows, "mu2", 175),
        "published mu1, 350 rows": partial(_rows, "mu1", 350),
    }
    for name, table in tables.items():
        for depth in (1, 2):
            yield Case(f"{name}, quartiles, depth {depth}", 0, partial(_by_quartiles, table, depth), SOLVERS)


def _rows(target: str, n: int) -> Table:
    return first_rows(published(target, 0), n)


def _by_quartiles(table: Callable[[], Table], depth: int) -> Problem:
    """Return a problem over 0/1 features, one for each quartile of each feature that parts the samples."""
    data = table()
    columns = []
    for column in data.features.T:
        limits = np.unique(np.quantile(column, [0.25, 0.5, 0.75]))
        columns += [column <= limit for limit in limits if limit < column.max()]
    return Problem(np.column_stack(columns).astype(np.float64), data.labels, depth=depth)


def summary(lines: list[Line]) -> str:
    """Return the tables: Benders beside both peers, and the flow rows beside the first."""
    races = (("octmip-benders", "odtlearn"), ("octmip-benders", "odtlearn-benders"), ("octmip-flow2", "odtlearn"))
    ran = {line["solver"] for line in lines}
    return "\n\n".join(race_table(lines, ours=ours, peer=peer) for ours, peer in races if {ours, peer} <= ran)
