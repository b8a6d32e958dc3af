"""Sums of float64 in exact rational arithmetic: the error of a regression tree, means and quantiles of its leaves.

Every float64 is a whole number times a power of two, so a list of them is a list of whole numbers over one common
denominator, and sums of products are sums of whole numbers of any length.
"""

import operator
from fractions import Fraction
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


def whole_numbers(values: Floats) -> tuple[list[int], int]:
    """Return whole numbers and the exponent e with ``values[i] == whole[i] * 2**-e``, exactly."""
    if not len(values):
        return [], 0
    mantissas, exponents = np.frexp(values)
    digits = np.ldexp(mantissas, 53).astype(np.int64)
    lowest = int(exponents[digits != 0].min(initial=1024))
    shifts = np.where(digits != 0, exponents - lowest, 0)
    if int(shifts.max()) == 0:
        return digits.tolist(), 53 - lowest
    return [digit << shift for digit, shift in zip(digits.tolist(), shifts.tolist(), strict=True)], 53 - lowest


class Slopes(NamedTuple):
    """What a unit of distance costs: ``up / over`` for a target above its prediction, ``down / over`` below it.

    The best constant is the quantile of level ``up / (up + down)``: the median of absolute errors, whose slopes are 1.
    """

    up: int
    down: int
    over: int

    @property
    def steepest(self) -> int:
        """The larger of the two, not divided."""
        return max(self.up, self.down)

    @property
    def per_move(self) -> Fraction:
        """By how much a best constant's cost changes at most, not divided, where targets move by 1 or less each.

        Twice ``up * down / (up + down)``: the constant moves to where a move up costs no more than one down.
        """
        return Fraction(2 * self.up * self.down, self.up + self.down)


def squared_errors(weights: Floats, targets: Floats, predicted: Floats) -> Fraction:
    """Return ``sum_i weights_i (targets_i - predicted_i)^2``, exactly."""
    whole, misses, exponents = _misses(weights, targets, predicted)
    total = sum(w * miss * miss for w, miss in zip(whole, misses, strict=True))
    return total * Fraction(2) ** -(exponents[0] + 2 * exponents[1])


def sloped_errors(weights: Floats, targets: Floats, predicted: Floats, slopes: Slopes) -> Fraction:
    """Return the weighted distances of targets and predictions, each times its slope, exactly."""
    whole, misses, exponents = _misses(weights, targets, predicted)
    products = list(map(operator.mul, whole, misses))
    above = sum(product for product in products if product > 0)
    below = sum(products) - above
    total = slopes.up * above - slopes.down * below
    return Fraction(total, slopes.over) * Fraction(2) ** -sum(exponents)


def _misses(weights: Floats, targets: Floats, predicted: Floats) -> tuple[list[int], list[int], tuple[int, int]]:
    """Return weights and differences as whole numbers, and the exponents of both."""
    whole, unit = whole_numbers(weights)
    both, exponent = whole_numbers(np.concatenate([targets, predicted]))
    return whole, [y - f for y, f in zip(both[: len(targets)], both[len(targets) :], strict=True)], (unit, exponent)


def weighted_mean(weights: Floats, targets: Floats) -> float:
    """Return the mean, rounded once; where all weights are 0 that of equal weights."""
    whole, _ = whole_numbers(_positive(weights))
    numbers, exponent = whole_numbers(targets)
    total = sum(w * y for w, y in zip(whole, numbers, strict=True))
    return float(Fraction(total, sum(whole)) * Fraction(2) ** -exponent)


def weighted_quantile(weights: Floats, targets: Floats, slopes: Slopes) -> float:
    """Return the lowest target of weight above 0 with ``up / (up + down)`` of the weight at or below it.

    Where all weights are 0 it is that of equal weights.
    """
    whole, _ = whole_numbers(_positive(weights))
    wanted, below = slopes.up * sum(whole), 0
    for i in np.argsort(targets, kind="stable").tolist():
        below += (slopes.up + slopes.down) * whole[i]
        if below >= wanted and whole[i] > 0:
            return float(targets[i])
    raise AssertionError("the weights of a leaf add up to their sum")


def _positive(weights: Floats) -> Floats:
    return weights if weights.any() else np.ones(len(weights))
