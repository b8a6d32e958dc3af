"""Numbers of float64 in exact arithmetic: every one is a whole number times a power of two.

Whatever decides between two costs compares them here: `exact_objective` of a tree, `exact_sum` of weights, and what is
shown is rounded afterwards, a bound by `rounded_down`. A rounded sum is not compared with an exact one.
"""

import math
from fractions import Fraction

import numpy as np
from numpy.typing import NDArray

from octmip.trees.problem import Problem
from octmip.trees.tree import Node, complexity, predict

MOST = 2**62  # larger whole numbers do not enter the native core


def power_of_two(exponent: int) -> Fraction:
    """Return 2**exponent."""
    return Fraction(2) ** int(exponent)


def whole_exponent(numbers: NDArray[np.float64]) -> int:
    """Return the least power of two that makes all of them whole; below 0 where they are multiples of one."""
    mantissas, exponents = np.frexp(numbers[numbers > 0])
    digits = np.ldexp(mantissas, 53).astype(np.int64)
    lowest = np.frexp((digits & -digits).astype(np.float64))[1] - 1  # place of the last binary digit that is not 0
    return int((53 - exponents - lowest).max(initial=-2000))


def floors(values: NDArray[np.float64], factor: Fraction, most: int) -> NDArray[np.int64]:
    """Return the values times a factor, rounded down, `most` at most: in exact arithmetic."""
    shift = factor.numerator.bit_length() - factor.denominator.bit_length()
    if factor == power_of_two(shift):
        with np.errstate(over="ignore"):
            scaled = np.floor(np.ldexp(values, shift))
        return np.minimum(np.minimum(scaled, float(MOST)).astype(np.int64), most)
    distinct, places = np.unique(values, return_inverse=True)
    ratios = (value.as_integer_ratio() for value in distinct.tolist())
    floors = [min(most, above * factor.numerator // (below * factor.denominator)) for above, below in ratios]
    return np.array(floors, dtype=np.int64)[places]


def exact_sum(values: NDArray[np.float64]) -> Fraction:
    """Return the sum of numbers, none of its digits lost."""
    ratios = [value.as_integer_ratio() for value in values.tolist()]
    denominator = max((below for _, below in ratios), default=1)
    return Fraction(sum(above * (denominator // below) for above, below in ratios), denominator)


def rounded_down(exact: Fraction) -> float:
    """Return the largest float64 that is not above a number."""
    nearest = float(exact)
    return nearest if Fraction(nearest) <= exact else math.nextafter(nearest, -math.inf)


def exact_objective(problem: Problem, tree: Node) -> Fraction:
    """Return the objective of a tree, none of its digits lost."""
    predicted, paid = predict(tree, problem.features), complexity(tree) * Fraction(problem.leaf_penalty)
    for code, prices in enumerate(problem.costs.tolist()):
        for label in np.unique(predicted[problem.codes == code]).tolist():
            rows = (problem.codes == code) & (predicted == label)
            paid += exact_sum(problem.weights[rows]) * Fraction(prices[label])
    return paid
