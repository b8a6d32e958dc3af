"""The best regression tree where samples are many: by runs of one column, or by stumps below every cut.

A tree over one column with c leaves is c runs of its sorted samples, whatever its shape, and any c <= 2^depth runs are
a tree of that depth. Over more columns each cut of the upper levels is tried and the last split is found among all by
sums over the samples before it. Errors are ratios of whole numbers, each rounded once to compare them; what is returned
is the exact objective of a tree, so no bound may lie above it. Imports nothing of octmip but the problem.
"""

import math
from fractions import Fraction
from functools import cached_property
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from octmip.trees.question.problem import Problem
from tests.oracles.regression_trees import slopes_of

Rows = NDArray[np.int64]
Numbers = NDArray[np.object_]


class Runs:
    """Samples of a problem in whole numbers.

    Attributes
    ----------
    weights, targets
        (n_samples,) Python's whole numbers.
    unit
        what one unit of their errors is worth.
    """

    def __init__(self, problem: Problem) -> None:
        self.problem = problem
        self.weights, weight_unit = _whole(problem.samples.weights)
        self.targets, target_unit = _whole(problem.samples.targets)
        self.slopes, slope_unit = (1, 1), Fraction(1)
        if problem.loss.name != "squared":
            up, down = slopes_of(problem)
            slope_unit = Fraction(1, math.lcm(up.denominator, down.denominator))
            self.slopes = int(up / slope_unit), int(down / slope_unit)
        self.unit = weight_unit * target_unit ** (2 if problem.loss.name == "squared" else 1) * slope_unit
        self.penalty = Fraction(problem.shape.leaf_penalty) / self.unit
        self.found: dict[tuple[bytes, int], Fraction] = {}

    @cached_property
    def misses(self) -> NDArray[Any]:
        """(n_samples, n_targets) sloped error of each sample under each target: small whole numbers if they are."""
        values, (up, down) = np.unique(self.targets), self.slopes
        above = self.targets[:, None] - values[None, :]
        misses: NDArray[Any] = self.weights[:, None] * np.maximum(up * above, -down * above)
        return misses.astype(np.int64) if int(misses.sum()) < 2**62 else misses

    def least(self) -> Fraction:
        """Return the least objective of a tree."""
        problem = self.problem
        order = np.argsort(problem.samples.features[:, 0], kind="stable")
        if problem.samples.n_features == 1:
            return self._least_runs(order) * self.unit
        return self._least(np.arange(problem.samples.n_samples), problem.shape.depth) * self.unit

    def prefixes(self, order: Rows) -> tuple[Numbers, Numbers]:
        """Return numerators and denominators of the errors of one constant for the first 1, 2, ... samples."""
        if self.problem.loss.name != "squared":
            least = np.cumsum(self.misses[order], axis=0).min(axis=1)
            return least.astype(object), np.full(len(order), 1, dtype=object)
        weights, targets = self.weights[order], self.targets[order]
        weight, first = np.cumsum(weights), np.cumsum(weights * targets)
        square = np.cumsum(weights * targets * targets)
        return square * weight - first * first, np.where(weight > 0, weight, 1)

    def _is_cut(self, order: Rows, feature: int) -> NDArray[np.bool_]:
        """(len(order) - 1,) whether a threshold parts the first 1, 2, ... samples from the others."""
        column = self.problem.samples.features[order, feature]
        return np.asarray(column[1:] > column[:-1])

    def _least_runs(self, order: Rows) -> Fraction:
        n, size, price = len(order), self.problem.shape.leaf_size, float(self.penalty)
        ends = np.concatenate([[0], np.flatnonzero(self._is_cut(order, 0)) + 1, [n]])
        numerators, denominators = (np.full((len(ends), len(ends)), one, dtype=object) for one in (0, 1))
        costs = np.full((len(ends), len(ends)), np.inf)
        for i, start in enumerate(ends[:-1].tolist()):
            above, below = self.prefixes(order[start:])
            places = ends[i + 1 :] - start - 1
            numerators[i, i + 1 :], denominators[i, i + 1 :] = above[places], below[places]
            is_wide = (places + 1 >= size) | ((start == 0) & (places == n - 1))
            costs[i, i + 1 :] = np.where(is_wide, (above[places] / below[places]).astype(float), np.inf)
        best, paths = costs[0].copy(), [[0, j] for j in range(len(ends))]
        found = [(best[-1], paths[-1])]
        for _ in range(1, min(2**self.problem.shape.depth, len(ends) - 1)):
            sums = best[:, None] + costs
            chosen = sums.argmin(axis=0)
            best, paths = sums.min(axis=0) + price, [[*paths[i], j] for j, i in enumerate(chosen.tolist())]
            found.append((best[-1], paths[-1]))
        path = min(found, key=lambda entry: entry[0])[1]
        errors = (Fraction(int(numerators[i, j]), int(denominators[i, j])) for i, j in pairwise(path))
        return sum(errors, (len(path) - 2) * self.penalty)

    def _least(self, rows: Rows, depth: int) -> Fraction:
        key = rows.tobytes(), depth
        if key not in self.found:
            self.found[key] = self._stump(rows) if depth == 1 else self._least_below(rows, depth)
        return self.found[key]

    def _least_below(self, rows: Rows, depth: int) -> Fraction:
        best, size = self._least(rows, depth - 1), self.problem.shape.leaf_size
        for feature in range(self.problem.samples.n_features):
            order = rows[np.argsort(self.problem.samples.features[rows, feature], kind="stable")]
            for k in (np.flatnonzero(self._is_cut(order, feature)) + 1).tolist():
                if size <= k <= len(rows) - size:
                    sides = (self._least(np.sort(part), depth - 1) for part in (order[:k], order[k:]))
                    best = min(best, sum(sides, self.penalty))
        return best

    def _stump(self, rows: Rows) -> Fraction:
        above, below = self.prefixes(rows)
        best, size = Fraction(int(above[-1]), int(below[-1])), self.problem.shape.leaf_size
        for feature in range(self.problem.samples.n_features):
            order = rows[np.argsort(self.problem.samples.features[rows, feature], kind="stable")]
            left, right = self.prefixes(order), self.prefixes(order[::-1])
            cuts = np.flatnonzero(self._is_cut(order, feature))
            cuts = cuts[(cuts + 1 >= size) & (len(rows) - cuts - 1 >= size)]
            if len(cuts):
                others = len(rows) - cuts - 2
                costs = left[0][cuts] / left[1][cuts] + right[0][others] / right[1][others]
                k = int(np.argmin(costs.astype(float)))
                sides = ((left, int(cuts[k])), (right, int(others[k])))
                errors = (Fraction(int(side[0][at]), int(side[1][at])) for side, at in sides)
                best = min(best, sum(errors, self.penalty))
        return best


def _whole(values: NDArray[np.float64]) -> tuple[Numbers, Fraction]:
    """Return whole numbers and the unit that they are multiples of."""
    ratios = [value.as_integer_ratio() for value in values.tolist()]
    below = math.lcm(*(denominator for _, denominator in ratios))
    whole = [above * (below // denominator) for above, denominator in ratios]
    return np.array([*whole, None], dtype=object)[:-1], Fraction(1, below)
