"""The best split of one node of a regression tree, by one feature or by a hyperplane.

A score says what each cut costs. `by_means` is the squared error around the means of both sides: it builds a tree from
the root. `by_sides` takes both subtrees as given and charges each sample the error of its side. Source of the second:
Carreira-Perpinan & Tavallali (2018), tree alternating optimization, Theorem 3.1.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from octmip.trees.nodes.digits import midpoint
from octmip.trees.nodes.tree import HyperplaneSplit, Leaf, Split, goes_left
from octmip.trees.question.problem import Problem

Floats = NDArray[np.float64]
Rows = NDArray[np.int64]
Score = Callable[[NDArray[np.int64]], Floats]
"""From orders of the samples (n_rows, n_columns) to the cost of each cut after a sample, (n_rows - 1, n_columns)."""
NOWHERE = Leaf(0)


@dataclass(frozen=True, slots=True, eq=False)
class Samples:
    """Samples of a node.

    Attributes
    ----------
    problem
        theirs.
    rows
        (n_rows,) which.
    usable
        (n_usable,) features that may be read.
    """

    problem: Problem
    rows: Rows
    usable: Rows

    def best(self, score: Score, pull: Floats) -> Split | HyperplaneSplit | None:
        """Return the split of least score, its sides empty; None where no cut leaves both sides large enough.

        `pull` (n_rows,) says how much a sample belongs to the left (below 0) or to the right; hyperplanes fit it.
        """
        values = self.problem.samples.features[np.ix_(self.rows, self.usable)]
        found = self._cut(values, score)
        split = None
        if found is not None:
            split = Split(int(self.usable[found[1]]), found[2], NOWHERE, NOWHERE)
        plane = self._plane(values, pull) if self.problem.shape.max_split_size > 1 else None
        if plane is None:
            return split
        sums = _sums(plane, self.problem.samples.features, self.rows)
        other = self._cut(sums[:, None], score)
        price = self.problem.shape.leaf_penalty * (len(plane.features) - 1)
        if other is None or (found is not None and found[0] <= other[0] + price):
            return split
        return HyperplaneSplit(plane.features, plane.coefficients, other[2], NOWHERE, NOWHERE)

    def _cut(self, values: Floats, score: Score) -> tuple[float, int, float] | None:
        order = np.argsort(values, axis=0, kind="stable")
        ordered = np.take_along_axis(values, order, axis=0)
        k, size = np.arange(1, len(values))[:, None], self.problem.shape.leaf_size
        is_cut = (ordered[1:] > ordered[:-1]) & (k >= size) & (len(values) - k >= size)
        if not is_cut.any():
            return None
        costs = np.where(is_cut, score(order), np.inf)
        row, column = (int(index) for index in np.unravel_index(int(costs.argmin()), costs.shape))
        return float(costs[row, column]), column, midpoint(float(ordered[row, column]), float(ordered[row + 1, column]))

    def _plane(self, values: Floats, pull: Floats) -> HyperplaneSplit | None:
        """Return a hyperplane by weighted least squares on the side that samples belong to, the largest terms kept."""
        weights = np.abs(pull)
        if not weights.any():
            return None
        spread = values.std(axis=0)
        kept = np.flatnonzero(spread > 1e-9 * np.abs(values).max(axis=0))
        weights = weights / weights.sum()
        slopes = np.zeros(0)
        for _ in range(2):  # all features, then the largest terms alone
            if not len(kept):
                return None
            scaled = values[:, kept] / spread[kept]
            scaled = scaled - weights @ scaled
            side = np.sign(pull) - weights @ np.sign(pull)
            gram = scaled.T @ (weights[:, None] * scaled) + 1e-6 * np.eye(len(kept))
            slopes = np.linalg.solve(gram, scaled.T @ (weights * side))
            largest = np.sort(np.argsort(-np.abs(slopes), kind="stable")[: self.problem.shape.max_split_size])
            kept, slopes = kept[largest], slopes[largest]
        slopes = slopes / spread[kept]
        kept, slopes = kept[slopes != 0], slopes[slopes != 0]
        if not len(kept) or not np.isfinite(slopes).all():
            return None
        return HyperplaneSplit(tuple(self.usable[kept].tolist()), tuple(slopes.tolist()), 0.0, NOWHERE, NOWHERE)


def _sums(plane: HyperplaneSplit, features: Floats, rows: Rows) -> Floats:
    total = np.zeros(len(rows))
    for feature, coefficient in zip(plane.features, plane.coefficients, strict=True):
        total += coefficient * features[rows, feature]
    return total


def by_means(weights: Floats, targets: Floats) -> Score:
    """Return the score of cuts by the squared error around the means of both sides, up to a constant."""

    def score(order: NDArray[np.int64]) -> Floats:
        # A side of samples without weight errs by nothing: 0 / 1.
        weight, target = np.cumsum(weights[order], axis=0), np.cumsum((weights * targets)[order], axis=0)
        left, right = weight[:-1], weight[-1] - weight[:-1]
        explained = target[:-1] ** 2 / np.where(left > 0, left, 1.0)
        rest = np.where(right > 0, right, 1.0)
        costs: Floats = -explained - (target[-1] - target[:-1]) ** 2 / rest
        return costs

    return score


def by_sides(left: Floats, right: Floats) -> Score:
    """Return the score of cuts by what samples cost on either side."""

    def score(order: NDArray[np.int64]) -> Floats:
        return np.cumsum((left - right)[order], axis=0)[:-1]

    return score


def parts(split: Split | HyperplaneSplit, features: Floats, rows: Rows) -> tuple[Rows, Rows]:
    """Return the samples on both sides of a split."""
    left = goes_left(split, features, rows)
    return rows[left], rows[~left]
