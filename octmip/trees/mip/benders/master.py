"""The master problem of a node: which cut it makes, in the paper's letters.

    x_c   1 if the node makes cut c            d   1 if it splits at all
    a_j   1 if it splits on feature j          b   the rank that it splits at, per number of ranks

    minimise    sum_c (theta_left,c + theta_right,c + penalty) x_c + leaf (1 - d)
    subject to  sum_c x_c = d,   sum_{c of j} x_c = a_j,   sum_c b_c x_c = b

theta_left,c and theta_right,c are the coefficients of the two Benders rows (`octmip.trees.mip.benders.bounds`). A
vertex of this polytope has one x_c at 1, or none, so its linear relaxation is exact; HiGHS solves it again from the
last basis whenever coefficients have risen.

Source: a, b, d: Bertsimas & Dunn (2017), Optimal classification trees, equations 2 to 5. Logic-based Benders cuts:
Hooker & Ottosson (2003), Logic-based Benders decomposition.
"""

from collections.abc import Mapping
from typing import Any

import highspy
import numpy as np
from numpy.typing import NDArray

from octmip.errors import SolverError
from octmip.trees.mip.benders.bounds import Bounds
from octmip.trees.mip.highs import worker
from octmip.trees.mip.highs.highs import arrays
from octmip.trees.mip.rows import Rows

OPTIONS: Mapping[str, Any] = {
    "presolve": "off",
    "solver": "simplex",
    "simplex_strategy": 4,  # primal: the last vertex stays feasible when coefficients rise
    "simplex_primal_edge_weight_strategy": 0,  # Dantzig: weights are more work than the few steps they save
    "threads": 1,
    "parallel": "off",
}
"""Measured on 34,980 cuts (1750 x 20), CPU s: first .05, with presolve .1; again after coefficients have risen .02, by
the dual simplex .7 to 1.3; without the cheapest feature .017."""

ANEW: Mapping[str, Any] = {
    "presolve": "choose",
    "simplex_strategy": 0,
    "simplex_primal_edge_weight_strategy": -1,
}
"""The primal simplex method ends a few degenerate masters without a verdict; HiGHS's own choice then solves them."""


class Master:
    """The master of one node, solved again and again by HiGHS."""

    def __init__(self, bounds: Bounds, leaf: float, goal: float) -> None:
        """Hand the master to HiGHS.

        Parameters
        ----------
        leaf
            price of the node without a split.
        goal
            cuts whose bound is not below it are left out: no tree that makes them is of use.
        """
        self._places = np.flatnonzero(bounds.price < goal)
        if not len(self._places):
            return
        self._rows, self._feature, self._of_feature = _rows(bounds, self._places, leaf)
        loaded = worker.load(arrays(self._rows))
        if loaded is None:
            raise SolverError("HiGHS refuses the master problem of a split; expected a model of numbers only")
        for option, value in OPTIONS.items():
            loaded.setOptionValue(option, value)
        self._highs = loaded
        self._x = self._rows.families["x"][0].astype(np.int32)

    def cheapest(
        self, price: NDArray[np.float64], below: float, most: int, order: NDArray[np.float64] | float = 0.0
    ) -> list[int]:
        """Return the places of the cheapest cut of each of the `most` cheapest features, as far as under `below`.

        Parameters
        ----------
        price
            (n_cuts,) what a tree that makes each cut costs at least.
        order
            (n_cuts,) of cuts of the same price the one of least order comes first; below the difference of two prices.
        """
        if not len(self._places):
            return []
        self._highs.changeColsCost(len(self._x), self._x, np.minimum(price + order, 2 * abs(below) + 1)[self._places])
        found: list[int] = []
        while len(found) < most:
            place = self._solved()
            if place is None or price[place] >= below:
                break
            found.append(place)
            self._highs.changeColBounds(self._column_of(place), 0.0, 0.0)
        for place in found:
            self._highs.changeColBounds(self._column_of(place), 0.0, 1.0)
        return found

    def _column_of(self, place: int) -> int:
        """Return the column a_j of the feature of a cut."""
        return self._of_feature[int(self._feature[np.searchsorted(self._places, place)])]

    def _solved(self) -> int | None:
        """Return the place of the cut that the optimum makes; None where it makes none."""
        self._highs.run_beside_others()
        status = self._highs.getModelStatus()
        if status != highspy.HighsModelStatus.kOptimal:
            status = self._solved_anew()
        if status != highspy.HighsModelStatus.kOptimal:
            raise SolverError(f"HiGHS ends the master problem of a split with {status.name}; expected an optimum")
        chosen = np.asarray(self._highs.getSolution().col_value)[self._x]
        return int(self._places[chosen.argmax()]) if chosen.max(initial=0.0) > 0.5 else None

    def _solved_anew(self) -> highspy.HighsModelStatus:
        """Solve without the last basis, as HiGHS itself chooses to, and return how it ends."""
        self._highs.clearSolver()
        for option, value in ANEW.items():
            self._highs.setOptionValue(option, value)
        self._highs.run_beside_others()
        for option in ANEW:
            self._highs.setOptionValue(option, OPTIONS[option])
        return self._highs.getModelStatus()


def _rows(bounds: Bounds, places: NDArray[np.int64], leaf: float) -> tuple[Rows, NDArray[np.int64], dict[int, int]]:
    """Return the master's rows, the feature of each cut, and the column a_j of each feature."""
    rows, feature, rank = Rows(), bounds.cuts.feature[places], bounds.cuts.rank[places]
    features = np.unique(feature)
    x = rows.columns("x", (range(len(feature)),))
    a, d, b = (rows.columns(letter, (range(size),)) for letter, size in (("a", len(features)), ("d", 1), ("b", 1)))
    unsplit = rows.columns("unsplit", (range(1),), cost=leaf)
    rows.add("one_cut", 0, 0, (x, 1.0), (d, -1.0))
    rows.add("split_or_not", 1, 1, (d, 1.0), (unsplit, 1.0))
    for j, column in zip(features, a, strict=True):
        rows.add("feature", 0, 0, (x[feature == j], 1.0), (column, -1.0))
    n_ranks = np.array(bounds.ranks.n_values, dtype=np.float64)
    rows.add("threshold", 0, 0, (x, (rank + 1) / n_ranks[feature]), (b, -1.0))
    return rows, feature, {int(j): int(column) for j, column in zip(features, a, strict=True)}
