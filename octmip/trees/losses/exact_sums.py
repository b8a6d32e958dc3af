"""Sums of float64 in exact rational arithmetic: the error of a regression tree, means and medians of its leaves.

Every float64 is a whole number times a power of two, so a list of them is a list of whole numbers over one common
denominator, and sums of products are sums of whole numbers of any length.
"""

from fractions import Fraction

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


def sum_of_errors(weights: Floats, targets: Floats, predicted: Floats, loss: str) -> Fraction:
    """Return ``sum_i weights_i |targets_i - predicted_i|``, squared where `loss` is "squared", exactly."""
    whole, unit = whole_numbers(weights)
    both, exponent = whole_numbers(np.concatenate([targets, predicted]))
    misses = [y - f for y, f in zip(both[: len(targets)], both[len(targets) :], strict=True)]
    if loss == "squared":
        total = sum(w * miss * miss for w, miss in zip(whole, misses, strict=True))
        return total * Fraction(2) ** -(unit + 2 * exponent)
    total = sum(w * abs(miss) for w, miss in zip(whole, misses, strict=True))
    return total * Fraction(2) ** -(unit + exponent)


def best_constant(weights: Floats, targets: Floats, loss: str) -> float:
    """Return the constant of least error, rounded once: the weighted mean, or the lowest weighted median.

    Where all weights are 0 it is that of equal weights.
    """
    if not weights.any():
        weights = np.ones(len(targets))
    whole, _ = whole_numbers(weights)
    if loss == "squared":
        numbers, exponent = whole_numbers(targets)
        total = sum(w * y for w, y in zip(whole, numbers, strict=True))
        return float(Fraction(total, sum(whole)) * Fraction(2) ** -exponent)
    half, below = sum(whole), 0
    for i in np.argsort(targets, kind="stable").tolist():
        below += 2 * whole[i]
        if below >= half and whole[i] > 0:
            return float(targets[i])
    raise AssertionError("the weights of a leaf add up to their sum")
