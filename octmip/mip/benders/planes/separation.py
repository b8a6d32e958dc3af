"""Separation: which points no split of few features tells apart, and the fewest of them for which that is so.

For one set of features, points P to be left and Q to be right, HiGHS finds the split with the widest empty band:

    maximise t   subject to   a'x_i + t <= b  (i in P),   a'x_i >= b  (i in Q),   sum_j |a_j| <= 1  (real coefficients)

The two are told apart if t reaches mu. Where it does not, the rows with a multiplier are a reason by themselves: by
duality the same rows alone have the same widest band. The union of such reasons over all sets of features is a core:
points of two classes that no split of the problem tells apart. Points are then dropped from it, one by one, as long as
it stays one (the deletion filter).

HiGHS's band may be too narrow by what its dual tolerance lets through (`octmip.mip.highs.claims`): the tolerance times
the ranges of columns and rows. So much is added before two groups are said not to be told apart; where a split is said
to exist, its tree is routed anew and counted.

Whole coefficients: where the linear program finds a band, the whole-numbered one is asked too.

Source: cores as cuts: Codato & Fischetti (2006), Combinatorial Benders' cuts. Deletion filter: Chinneck & Dravnieks
(1991), Locating minimal infeasible constraint sets in linear programs.
"""

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import highspy
import numpy as np
from numpy.typing import NDArray

from octmip.errors import SolverError
from octmip.mip.benders.planes.master import add_line
from octmip.mip.benders.planes.question import Question
from octmip.mip.blocks.hyperplanes import Space
from octmip.mip.highs import worker
from octmip.mip.highs.highs import arrays
from octmip.mip.rows import Rows
from octmip.tree import HyperplaneSplit

Points = NDArray[np.int64]
TOLERANCE = 1e-9  # of the linear programs; mu is 1e-4 at least
MULTIPLIER = 1e-9  # below it a row has none


@dataclass(frozen=True, slots=True, eq=False)
class Band:
    """The widest band between two groups of points.

    Attributes
    ----------
    width
        of the band, at most.
    reason
        points that have no wider one by themselves.
    normal, middle
        (n_features of the set,) and offset of the split in its middle.
    """

    width: float
    reason: Points
    normal: NDArray[np.float64]
    middle: float


class Separator:
    """The linear program of one set of features, solved again for other points from its last basis."""

    def __init__(self, space: Space, mu: float) -> None:
        rows, n = Rows(), len(space.x)
        line = add_line(rows, space, integer=False)
        t = rows.columns("t", (range(1),), 0, 3 * space.reach, cost=-1.0)
        rows.add("left", -np.inf, np.inf, *line.terms, (np.repeat(t[None, :], n, axis=0), 1.0))
        rows.add("right", -np.inf, np.inf, *line.terms)
        self.is_integer, self.n, self.k, self.mu, self.reach = space.is_integer, n, space.x.shape[1], mu, space.reach
        self._first = rows.n_rows - 2 * n
        loaded = worker.load(arrays(rows))
        if loaded is None:
            raise SolverError("HiGHS refuses the model of a band; expected a model of numbers only")
        for name in ("primal_feasibility_tolerance", "dual_feasibility_tolerance"):
            loaded.setOptionValue(name, TOLERANCE)
        for name, value in (("presolve", "off"), ("threads", 1)):
            loaded.setOptionValue(name, value)
        self._highs: Any = loaded  # its annotations lack changeRowsBounds
        self._groups = np.arange(self._first, self._first + 2 * n, dtype=np.int32)
        self._coefficients = np.arange(2 * self.k, dtype=np.int32)

    def band(self, left: Points, right: Points) -> Band:
        """Return the widest band between two groups of points, neither empty."""
        low, high = np.full(2 * self.n, -np.inf), np.full(2 * self.n, np.inf)
        high[left], low[self.n + right] = 0.0, 0.0
        self._highs.changeRowsBounds(2 * self.n, self._groups, low, high)
        slack = TOLERANCE * 8 * self.reach * (len(left) + len(right) + 2 * self.k + 2)
        found = self._solved(slack)
        if self.is_integer and found.width >= self.mu:
            self._make(highspy.HighsVarType.kInteger)
            found = self._solved(slack)
            self._make(highspy.HighsVarType.kContinuous)
            return Band(found.width, np.concatenate([left, right]), np.round(found.normal), found.middle)
        return found

    def _solved(self, slack: float) -> Band:
        self._highs.run_beside_others()
        status = self._highs.getModelStatus()
        if status != highspy.HighsModelStatus.kOptimal:
            raise SolverError(f"HiGHS ends the model of a band with {status.name}; expected an optimum")
        solution = self._highs.getSolution()
        values = np.asarray(solution.col_value)
        normal, (offset, width) = values[: self.k] - values[self.k : 2 * self.k], values[2 * self.k :]
        multipliers = np.abs(np.asarray(solution.row_dual)[self._first :])
        counts = multipliers.reshape(2, -1).max(axis=0) > MULTIPLIER if len(multipliers) else np.zeros(self.n, bool)
        at_most = max(float(width), -float(self._highs.getInfo().mip_dual_bound) if not len(multipliers) else 0.0)
        return Band(at_most + slack, np.flatnonzero(counts), normal, float(offset - width / 2))

    def _make(self, kind: highspy.HighsVarType) -> None:
        self._highs.changeColsIntegrality(
            len(self._coefficients), self._coefficients, np.full(len(self._coefficients), kind)
        )


@dataclass(slots=True, eq=False)
class Separation:
    """All sets of features of a question, the one that told points apart last first.

    Attributes
    ----------
    check
        called before every model; may raise at a limit.
    n_models
        solved so far.
    """

    question: Question
    check: Callable[[], None]
    n_models: int = 0
    _separators: dict[tuple[int, ...], Separator] = field(default_factory=dict)
    _order: list[tuple[int, ...]] = field(default_factory=list)

    def __post_init__(self) -> None:
        self._order = list(self.question.sets)

    def split(self, points: Points) -> HyperplaneSplit | None:
        """Return a split that tells points of two classes apart, None if there is none."""
        for features in list(self._order):
            band = self._band(features, points)
            if self._is_apart(band):
                return None if band is None else self.question.split(features, band.normal, band.middle)
        return None

    def core(self, points: Points, is_free: NDArray[np.bool_]) -> Points | None:
        """Return few of some points of two classes that no split tells apart; None if one does.

        Parameters
        ----------
        is_free
            (n_points of the question,) points that the other side of the root might keep as well. As few of these as
            can be: the others are kept here by every tree of the case that keeps them at all.
        """
        core = np.zeros(0, dtype=np.int64)
        reasons: dict[tuple[int, ...], Points] = {}
        for features in list(self._order):
            band = self._band(features, core)
            if self._is_apart(band):
                wider = self._band(features, points)
                if self._is_apart(wider):
                    self._order.remove(features)
                    self._order.insert(0, features)
                    return None
                assert wider is not None
                core = np.union1d(core, wider.reason)
                band = self._band(features, core)
                if self._is_apart(band):  # a multiplier was too small to be seen
                    core, band = points, wider
            assert band is not None
            reasons[features] = band.reason
        fixed = points[~is_free[points]]
        core = np.concatenate([core[is_free[core]], fixed])  # the free ones first, all others there to replace them
        return np.sort(self._filtered(core, reasons))

    def _filtered(self, core: Points, reasons: dict[tuple[int, ...], Points]) -> Points:
        """Drop points from a core as long as every set of features has a reason left."""
        for point in core.tolist():
            fewer = core[core != point]
            changed: dict[tuple[int, ...], Points] = {}
            for features in self._order:
                if point in reasons[features]:
                    band = self._band(features, fewer)
                    if self._is_apart(band):
                        break
                    assert band is not None
                    changed[features] = band.reason
            else:
                core = fewer
                reasons |= changed
        return core

    def _band(self, features: tuple[int, ...], points: Points) -> Band | None:
        """Return the widest band between the classes of some points; None where there is one class only."""
        codes = self.question.code[points]
        if len(points) == 0 or (codes == codes[0]).all():
            return None
        self.check()
        self.n_models += 1
        if features not in self._separators:
            self._separators[features] = Separator(self.question.space_in(features), self.question.mu)
        is_first = codes == codes.min()
        return self._separators[features].band(points[is_first], points[~is_first])

    def _is_apart(self, band: Band | None) -> bool:
        return band is None or band.width >= self.question.mu
