"""Weights, costs and penalty as whole numbers, where float64 holds their sums."""

import math
from dataclasses import dataclass
from fractions import Fraction

import numpy as np
from numpy.typing import NDArray

from octmip.trees.encoding.numbers import MOST, floors, power_of_two, rounded_down, whole_exponent
from octmip.trees.problem import Problem
from octmip.trees.tree import Node, complexity, predict

CAPACITY = 2.0**52  # whole-numbered objectives stay below it, so float64 holds every one of them exactly


@dataclass(frozen=True, slots=True, eq=False)
class IntegerCosts:
    """Weights, costs and penalty as whole numbers of ``2**-exponent``, none above the true one.

    ``weights[i] * costs[rows[i], k] * 2**-exponent <= w_i * (C[label_i, k] - cheapest of C[label_i])`` for every sample
    i and class k; the cheapest answers together are `base`, which no tree avoids (0 where nothing is rounded: there the
    costs are whole as they stand).

    Attributes
    ----------
    weights
        (n_samples,) int64.
    rows
        (n_samples,) int64, row of `costs` of each sample: its class, or one of its own.
    costs
        (n_rows, n_rows) int64; columns beyond the classes are no answers and cost as much as the worst.
    penalty
        of one feature in one split.
    exponent
        of the unit.
    weight_exponent
        the part of it that scales the weights, where nothing is rounded.
    base
        what every tree costs besides.
    is_rounded
        whether a whole-numbered objective may lie below the true one, or a cost was lowered.
    tolerance
        how far, at most, for trees no worse than the one that was known; 0 when nothing was rounded.
    """

    weights: NDArray[np.int64]
    rows: NDArray[np.int64]
    costs: NDArray[np.int64]
    penalty: int
    exponent: int
    weight_exponent: int
    base: Fraction
    is_rounded: bool
    tolerance: float

    @property
    def unit(self) -> float:
        """Factor from a whole-numbered objective to the problem's, `base` left out."""
        return math.ldexp(1.0, -self.exponent)

    @property
    def weight_unit(self) -> float:
        """The part of `unit` that scales the weights."""
        return math.ldexp(1.0, -self.weight_exponent)

    def value(self, whole: int) -> float:
        """Return the largest float64 not above a whole-numbered objective or bound, in the problem's units."""
        return rounded_down(self.base + whole * power_of_two(-self.exponent))

    def whole_objective(self, problem: Problem, tree: Node) -> int:
        """Return the objective of a tree as the core counts it."""
        paid = self.weights * self.costs[self.rows, predict(tree, problem.features)]
        return int(paid.sum()) + self.penalty * complexity(tree)


def whole_costs(problem: Problem) -> IntegerCosts | None:
    """Return the costs of a problem whose objectives are whole numbers of some power of two, all below `CAPACITY`."""
    weight_exponent, cost_exponent = (max(0, whole_exponent(array)) for array in (problem.weights, problem.costs))
    weights = floors(problem.weights, power_of_two(weight_exponent), MOST)
    costs = floors(problem.costs.ravel(), power_of_two(cost_exponent), MOST).reshape(problem.costs.shape)
    most = float(weights.sum(dtype=np.float64)) * max(float(costs.max()), 1.0)
    if most + 1 >= CAPACITY:
        return None
    # A penalty above every other cost is cut to just above: no tree with a split is optimal either way, where none must
    # have one.
    price = Fraction(problem.leaf_penalty) * power_of_two(weight_exponent + cost_exponent)
    n_asked = problem.most_asked_splits
    more = price.denominator.bit_length() - 1 if price < most + 1 or n_asked else 0
    if (Fraction(most) + n_asked * price) * 2**more + 1 >= CAPACITY:
        return None
    above_all = int(weights.sum()) * max(int(costs.max()) << more, 1) + 1
    penalty = int(price * 2**more) if n_asked else min(int(price * 2**more), above_all)
    exponent = weight_exponent + cost_exponent + more
    zero = Fraction(0)
    return IntegerCosts(weights, problem.codes, costs << more, penalty, exponent, weight_exponent, zero, False, 0.0)
