"""The master of one case: the root's split reads some features, and the leaves on each side of it name some labels.

    up_j, down_j, b   the split's coefficients a = up - down on the transformed features, and its offset
    f_i,side          1 if point i is on that side of the root and a leaf there names its class: it is kept
    e_i               1 if it is not kept

    subject to   a'x_i + mu <= b where f_i,left = 1,   a'x_i >= b where f_i,right = 1,   sum_j |a_j| <= 1 (real)
                 f_i,left + f_i,right + e_i = 1,   f_i,side = 0 if no leaf of that side names y_i
                 sum_i w_i e_i < target
                 sum_{i in A} f_i,side <= |A| - 1   for every core A (`octmip.mip.benders.planes.separation`)

HiGHS is asked for any solution. Where there is none, no tree of the case is cheaper than the target. A split and its
mirror image are the same, so the heaviest point is not kept on the left where both sides name the same labels.
"""

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from octmip.mip.benders.planes.question import Case, Question
from octmip.mip.blocks.hyperplanes import Space
from octmip.mip.rows import Columns, Rows, Term

SIDES = range(2)
HALF = 0.5  # prices are whole


@dataclass(frozen=True, slots=True, eq=False)
class Line:
    """The columns of a split, and a'x_i - b for every point as terms of rows."""

    up: Columns
    down: Columns
    b: Columns
    terms: tuple[Term, ...]


def add_line(rows: Rows, space: Space, *, integer: bool) -> Line:
    """Add the columns of a split of all features of a space."""
    features, most = range(space.x.shape[1]), space.coefficient
    up, down = (rows.columns(name, (features,), 0, most, integer=integer) for name in ("up", "down"))
    b = rows.columns("b", (range(1),), -3 * space.reach, 3 * space.reach)
    if not space.is_integer:
        rows.add("size", -np.inf, 1, (up, 1.0), (down, 1.0))
    of_all = np.zeros((len(space.x), 1), dtype=np.int64)
    return Line(up, down, b, ((up + of_all, space.x), (down + of_all, -space.x), (b + of_all, -1.0)))


@dataclass(frozen=True, slots=True, eq=False)
class Master:
    """The rows of a case, and the way from a solution to a split and to the points kept on its sides."""

    rows: Rows
    line: Line
    f: Columns  # (n_points, 2)

    def split(self, values: NDArray[np.float64]) -> tuple[NDArray[np.float64], float]:
        """Return the root's coefficients on the transformed features of the case, and its offset."""
        return values[self.line.up] - values[self.line.down], float(values[self.line.b[0]])

    def kept(self, values: NDArray[np.float64]) -> list[NDArray[np.int64]]:
        """Return the points that each side keeps, the left one first."""
        return [np.flatnonzero(values[self.f[:, side]] > 0.5) for side in SIDES]


def encode(question: Question, case: Case, target: int, cores: Iterable[NDArray[np.int64]], rows: Rows) -> Master:
    """Return the master of a case for trees cheaper than a target."""
    n, space = len(question.code), question.space_in(case.features)
    line = add_line(rows, space, integer=space.is_integer)
    is_named = np.column_stack([np.isin(question.code, labels) for labels in case.labels])
    if case.labels[0] == case.labels[1]:
        is_named[int(question.weight.argmax()), 0] = False
    f = rows.columns("f", (range(n), SIDES), 0, is_named, integer=True)
    e = rows.columns("e", (range(n),), integer=True)
    wide = 2 * space.reach
    rows.add("left", -np.inf, wide, *line.terms, (f[:, [0]], wide + question.mu))
    rows.add("right", -wide, np.inf, *line.terms, (f[:, [1]], -wide))
    rows.add("one_side", 1, 1, (f, 1.0), (e[:, None], 1.0))
    rows.add("cheaper", -np.inf, target - HALF, (e, question.weight))
    for core in cores:
        rows.add("core", -np.inf, len(core) - 1, (f[core].T, 1.0))
    return Master(rows, line, f)
