"""Prices: the objective of a model in whole numbers of moderate size, and its distance from the problem's own units.

    price_ik = weights_i * costs[profile_i, k]   of predicting k for sample i;   penalty   of one feature in one split

A problem whose weights, costs and penalty are whole numbers, `LARGEST` at most in sum, is priced as it stands. HiGHS
computes in float64 with tolerances between 1e-6 and 1e-10, so numbers of 1e12 beside numbers of 1 are not an objective
to it. Any other problem is brought to such whole numbers by two steps, each with what it costs:

* What exceeds the objective U of a known tree is cut to one price just above U. A tree that pays it costs more than U,
  so it is no better than the known one, whatever else it costs.
* What remains is divided by a unit and rounded. The unit is the greatest common divisor of all prices, or a power of
  ten that nearly is one (decimal weights), if the sum stays below `LARGEST` with it; else the power of two at which it
  does.

So for every tree T of the problem      true(T) >= min(U, unit * priced(T) - above)
and for a tree that pays no cut price   true(T) <= unit * priced(T) + below

where `above` and `below` add up, sample by sample, the most that rounding gave or took: both are exact fractions.
"""

import math
from dataclasses import dataclass
from fractions import Fraction

import numpy as np
from numpy.typing import NDArray

from octmip.trees.nodes.tree import Node, complexity, predict
from octmip.trees.question.problem import Problem

LARGEST = 10**6  # of the prices in sum: HiGHS's finest tolerances then move the objective by far less than 1
NEARLY_WHOLE = Fraction(1, 10**9)  # decimal weights are this close to whole numbers of their last digit


@dataclass(frozen=True, slots=True, eq=False)
class Prices:
    """The cost of predicting each label for each sample, as a model sees it.

    Attributes
    ----------
    weights
        (n_samples,) of the samples.
    profile
        (n_samples,) row of `costs` that a sample pays by; its class, unless rounding parts samples of a class.
    costs
        (n_profiles, n_classes) of predicting each label.
    penalty
        of one feature in one split.
    unit
        value of one unit of price in the problem's objective.
    above, below
        the most that rounding gave or took, in the problem's objective.
    limit
        what costs more is cut to just above it, so no bound above it is one of the problem; None: nothing is cut.
    """

    weights: NDArray[np.float64]
    profile: NDArray[np.int64]
    costs: NDArray[np.float64]
    penalty: float
    unit: Fraction = Fraction(1)
    above: Fraction = Fraction(0)
    below: Fraction = Fraction(0)
    limit: Fraction | None = None

    @property
    def n_profiles(self) -> int:
        """Number of rows of `costs`."""
        return len(self.costs)

    @property
    def is_zero_one(self) -> bool:
        """Whether the costs are 0/1, so that predicting k saves the weight of class k in a leaf."""
        return self.costs.shape[0] == self.costs.shape[1] and np.array_equal(self.costs, 1 - np.eye(len(self.costs)))

    @property
    def worst(self) -> float:
        """Cost when every sample has its most expensive label: no leaf can cost more."""
        return float((self.weights * self.costs[self.profile].max(axis=1)).sum())

    def of_labels(self, rows: NDArray[np.int64]) -> NDArray[np.float64]:
        """Return the price of predicting each class for the samples `rows`, shape (n_classes,)."""
        return np.bincount(self.profile[rows], self.weights[rows], self.n_profiles) @ self.costs

    def of_tree(self, problem: Problem, tree: Node) -> float:
        """Return the price of a tree, every sample routed."""
        paid = self.weights * self.costs[self.profile, predict(tree, problem.samples.features)]
        return float(paid.sum()) + self.penalty * complexity(tree)

    def true(self, price: float) -> float:
        """Return a price in the problem's units, to be shown: not rounded to the safe side."""
        return float(self.unit) * price if math.isfinite(price) else price

    def lower_bound(self, price: int) -> Fraction:
        """Return the least cost of a tree in the problem's units when none is priced below `price`."""
        bound = self.unit * price - self.above
        return bound if self.limit is None else min(bound, self.limit)


def own_prices(problem: Problem) -> Prices:
    """Return the prices of a problem as they stand."""
    return Prices(problem.samples.weights, problem.cost_rows, problem.cost_table, problem.shape.leaf_penalty)


def whole_prices(problem: Problem, known: float) -> Prices:
    """Return the prices of a problem in whole numbers, given the objective of a known tree."""
    own = own_prices(problem)
    if problem.has_integer_costs and max(own.worst, own.penalty) <= LARGEST:
        return own
    kinds, kind_of, counts = np.unique(
        np.column_stack([problem.samples.weights, problem.cost_rows]), axis=0, return_inverse=True, return_counts=True
    )
    of_class = [[Fraction(c) for c in row] for row in problem.cost_table.tolist()]
    table = [[Fraction(w) * c for c in of_class[int(y)]] for w, y in kinds.tolist()]
    rounding = _rounding(problem, table, counts.tolist(), Fraction(known))
    whole = np.array([[rounding.whole(price) for price in row] for row in table], dtype=float)
    weights, profile, costs = _profiles(whole, None if problem.has_sample_costs else kinds[:, 1].astype(np.int64))
    kind_of = kind_of.ravel()
    return Prices(
        weights[kind_of],
        profile[kind_of],
        costs,
        float(rounding.whole(Fraction(problem.shape.leaf_penalty))),
        rounding.unit,
        rounding.above,
        rounding.below,
        rounding.limit,
    )


@dataclass(frozen=True, slots=True)
class _Rounding:
    """A way to make a price a whole number: divided by a unit, or cut to `cut` above `limit`."""

    unit: Fraction
    limit: Fraction
    cut: int
    above: Fraction
    below: Fraction

    def whole(self, price: Fraction) -> int:
        return round(price / self.unit) if price <= self.limit else self.cut


def _rounding(problem: Problem, table: list[list[Fraction]], counts: list[int], limit: Fraction) -> _Rounding:
    """Return the rounding of the rows of `table`, each with its count of samples, and of the penalty."""
    penalty = Fraction(problem.shape.leaf_penalty)
    kept = sorted({price for row in (*table, [penalty]) for price in row if 0 < price <= limit})
    total = sum((count * min(max(row), limit) for row, count in zip(table, counts, strict=True)), Fraction(0))
    unit = _unit(kept, max(total, limit)) if kept else max(limit, Fraction(1))
    most_features = min(2**problem.shape.depth - 1, problem.samples.n_samples) * problem.shape.max_split_size
    above = below = Fraction(0)
    for row, count in (*zip(table, counts, strict=True), ([penalty], most_features)):
        errors = [round(price / unit) * unit - price for price in row if price <= limit]
        above += count * max([*errors, Fraction(0)])
        below -= count * min([*errors, Fraction(0)])
    return _Rounding(unit, limit, math.ceil((limit + above) / unit) + 1, above, below)


def _unit(kept: list[Fraction], total: Fraction) -> Fraction:
    """Return the unit that prices, ascending, are divided by: see the module."""
    finest = total / LARGEST
    denominator = math.lcm(*(price.denominator for price in kept))
    common = Fraction(math.gcd(*(int(price * denominator) for price in kept)), denominator)
    if common >= finest:
        return common
    for exponent in range(math.floor(math.log10(kept[-1])), math.ceil(math.log10(finest)) - 1, -1):
        ten = Fraction(10) ** exponent
        if all(abs(price / ten - round(price / ten)) <= NEARLY_WHOLE for price in kept):
            return ten
    return Fraction(2) ** math.ceil(math.log2(finest))


def _profiles(
    whole: NDArray[np.float64], codes: NDArray[np.int64] | None
) -> tuple[NDArray[np.float64], NDArray[np.int64], NDArray[np.float64]]:
    """Return weights (n_rows,), profiles (n_rows,) and costs whose products are the rows of `whole`.

    Rows that cost nothing for their own class and the same for every other are weights beside 0/1 costs.
    """
    n_rows, n_classes = whole.shape
    weights = whole.max(axis=1)
    zero_one = 1 - np.eye(n_classes)
    if codes is not None and np.array_equal(weights[:, None] * zero_one[codes], whole):
        return weights, codes, zero_one
    costs, profile = np.unique(whole, axis=0, return_inverse=True)
    return np.ones(n_rows), profile.ravel().astype(np.int64), costs
