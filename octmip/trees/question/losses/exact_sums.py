"""Sums of float64 in exact rational arithmetic: the error of a regression tree, means and quantiles of its leaves.

Every float64 is a whole number times a power of two, so a list of them is a list of whole numbers over one common
denominator, and sums of products are sums of whole numbers of any length. Rows of one weight and one prediction, which
most tables are made of, are summed together in limbs of 27 binary digits, which float64 adds up without rounding.
"""

import operator
from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
LIMB = 27
"""Binary digits of a limb: the sum of `MOST_ROWS` of them is exact in float64."""
FEWEST_ROWS, MOST_ROWS = 1000, 2**26
ROWS_OF_GROUP = 8
"""Rows of a group, on the mean, from which on groups are quicker than rows."""


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
    alike = _Alike.of(weights, predicted)
    if alike is None:
        whole, misses, exponents = _misses(weights, targets, predicted)
        total = sum(w * miss * miss for w, miss in zip(whole, misses, strict=True))
        return total * Fraction(2) ** -(exponents[0] + 2 * exponents[1])
    squares, sums = alike.sums(targets, 2), alike.sums(targets, 1)
    groups = alike.groups(squares, sums)
    return Fraction(sum(w * (square - 2 * f * plain + n * f * f) for w, f, n, square, plain in groups))


def sloped_errors(weights: Floats, targets: Floats, predicted: Floats, slopes: Slopes) -> Fraction:
    """Return the weighted distances of targets and predictions, each times its slope, exactly."""
    total = Fraction(0)
    is_above = targets > predicted
    for side, slope in ((is_above, slopes.up), (~is_above, -slopes.down)):
        total += Fraction(slope, slopes.over) * _sum_of_misses(weights[side], targets[side], predicted[side])
    return total


def _sum_of_misses(weights: Floats, targets: Floats, predicted: Floats) -> Fraction:
    """Return ``sum_i weights_i (targets_i - predicted_i)``, exactly."""
    alike = _Alike.of(weights, predicted)
    if alike is None:
        whole, misses, exponents = _misses(weights, targets, predicted)
        return Fraction(sum(map(operator.mul, whole, misses)) * Fraction(2) ** -sum(exponents))
    return Fraction(sum(w * (plain - n * f) for w, f, n, plain in alike.groups(alike.sums(targets, 1))))


def _misses(weights: Floats, targets: Floats, predicted: Floats) -> tuple[list[int], list[int], tuple[int, int]]:
    """Return weights and differences as whole numbers, and the exponents of both."""
    whole, unit = whole_numbers(weights)
    both, exponent = whole_numbers(np.concatenate([targets, predicted]))
    return whole, [y - f for y, f in zip(both[: len(targets)], both[len(targets) :], strict=True)], (unit, exponent)


@dataclass(frozen=True, slots=True)
class _Alike:
    """Rows in groups of one weight and one prediction."""

    group: NDArray[np.intp]
    weights: Floats
    predicted: Floats

    @classmethod
    def of(cls, weights: Floats, predicted: Floats) -> "_Alike | None":
        """Return the groups; None where there are too few rows, or too many groups, to gain by them."""
        if not FEWEST_ROWS <= len(weights) <= MOST_ROWS:
            return None
        (kinds, kind), (values, value) = _kinds(weights), _kinds(predicted)
        if len(kinds) * len(values) > len(weights) // ROWS_OF_GROUP:
            return None
        return cls(kind * len(values) + value, np.repeat(kinds, len(values)), np.tile(values, len(kinds)))

    def groups(self, *sums: list[Fraction]) -> Iterator[tuple[Fraction | int, ...]]:
        """Yield weight, prediction, number of rows and the sums of each group."""
        counts = np.bincount(self.group, minlength=len(self.weights)).tolist()
        pairs = zip(map(Fraction, self.weights.tolist()), map(Fraction, self.predicted.tolist()), counts, strict=True)
        yield from ((*pair, *own) for pair, own in zip(pairs, zip(*sums, strict=True), strict=True))

    def sums(self, values: Floats, power: int) -> list[Fraction]:
        """Return for each group the exact sum of the values, or of their squares."""
        mantissas, exponents = np.frexp(values)
        digits = np.ldexp(mantissas, 53).astype(np.int64)
        places = np.flatnonzero(np.bincount(exponents - exponents.min())) + exponents.min()
        index = np.zeros(int(places[-1] - places[0]) + 1, dtype=np.intp)
        index[places - places[0]] = np.arange(len(places))
        key = self.group * len(places) + index[exponents - places[0]]
        whole = np.zeros(len(self.weights) * len(places), dtype=object)
        high, low = digits >> LIMB, digits & (1 << LIMB) - 1
        terms = [(0, digits)] if power == 1 else [(2 * LIMB, high * high), (LIMB + 1, high * low), (0, low * low)]
        for shift, term in terms:
            for more, limb in ((LIMB, term >> LIMB), (0, term & (1 << LIMB) - 1)):
                total = np.bincount(key, limb, minlength=len(whole))
                whole += total.astype(np.int64).astype(object) << shift + more
        units = [Fraction(2) ** (power * (int(place) - 53)) for place in places]
        return [sum(map(operator.mul, row, units), Fraction(0)) for row in whole.reshape(-1, len(places)).tolist()]


def _kinds(values: Floats) -> tuple[Floats, NDArray[np.intp]]:
    """Return the distinct values and which of them each one is."""
    if (values == values[0]).all():
        return values[:1], np.zeros(len(values), dtype=np.intp)
    kinds, kind = np.unique(values, return_inverse=True)
    return kinds, kind


def weighted_mean(weights: Floats, targets: Floats) -> float:
    """Return the mean, rounded once; where all weights are 0 that of equal weights."""
    positive = _positive(weights)
    total = _sum_of_misses(positive, targets, np.zeros(len(targets)))
    return float(total / _sum_of_misses(np.ones(len(positive)), positive, np.zeros(len(positive))))


def weighted_quantile(weights: Floats, targets: Floats, slopes: Slopes) -> float:
    """Return the lowest target of weight above 0 with ``up / (up + down)`` of the weight at or below it.

    Where all weights are 0 it is that of equal weights.
    """
    order, positive = np.argsort(targets, kind="stable"), _positive(weights)
    is_one = bool((positive == positive[0]).all())
    whole = np.ones(len(order), dtype=np.int64) if is_one else np.array(whole_numbers(positive[order])[0], dtype=object)
    below = np.cumsum(whole)
    wanted = -(-slopes.up * int(below[-1]) // (slopes.up + slopes.down))  # rounded up, in whole numbers of any length
    reached = (below >= wanted) & (whole > 0)
    return float(targets[order[int(reached.argmax())]])


def _positive(weights: Floats) -> Floats:
    return weights if weights.any() else np.ones(len(weights))
