"""A problem with a least weight of leaves as one with a least number of rows, each row as often as it weighs units.

Row i of weight w_i > 0 stands s_i times, the first with its weight and the others with none, and a leaf needs S rows:

    s_i = ceil(min(w_i, W) / u),    S = ceil(W / u)        W least weight of a leaf, u the unit

Every tree costs the same in both problems. A leaf of weight W or more has S rows or more: one with w_i >= W alone,
others sum_i s_i >= sum_i w_i / u >= W / u. So every tree of the problem is one of the rows', and their bound is a bound
of the problem. The converse holds where the weights below W are multiples of u. Elsewhere the best tree of the rows is
weighed again: if it is a tree of the problem, it is the best one there, too.
"""

import math

import numpy as np
from numpy.typing import NDArray

from octmip.trees.question.problem import Problem

LARGEST_DIVISOR = 12
"""The unit is the least weight, or it divided by a whole number up to this."""
ROUNDING = 1e-9
"""Of a multiple of the unit: weights are sums of float64."""
BELOW = 1e-12
"""Share that rounding may have added to a weight in units; of W ten times as much, so that no leaf is lost."""
FEW_ROWS, MOST_ROWS = 20_000, 1_000_000
"""Rows of a first solve, whose tree nearly always holds, and the most that is repeated to be exact."""


def unit_of(weights: NDArray[np.float64], most: int) -> float | None:
    """Return the largest number found of which all weights are multiples, `most` in all; None without one."""
    for divisor in range(1, LARGEST_DIVISOR + 1):
        unit = weights.min(initial=np.inf) / divisor
        multiples = weights / unit
        whole: NDArray[np.float64] = np.round(multiples)
        if (np.abs(multiples - whole) <= ROUNDING * whole).all() and whole.sum() <= most:
            return float(unit)
    return None


def units_of(problem: Problem) -> list[float]:
    """Return the units to count a problem's leaves by, that of the fewest rows first."""
    least = problem.shape.least_leaf_weight
    weights = problem.samples.weights[problem.samples.weights > 0]
    light = weights[weights < least]
    exact = unit_of(light, MOST_ROWS) if len(light) else least
    total, n = float(np.minimum(weights, least).sum()), len(weights)
    rows = [max(2 * n, min(20 * n, FEW_ROWS))]
    while rows[-1] <= FEW_ROWS:
        rows.append(10 * rows[-1])
    if exact is None or total / exact > MOST_ROWS:
        return [total / count for count in rows]
    return [*(total / count for count in rows if count < total / exact), exact]


def sized_rows(problem: Problem, unit: float) -> Problem:
    """Return a problem with a `leaf_weight` over rows that are counted by a unit: every tree costs the same there."""
    kept = np.flatnonzero(problem.samples.weights > 0)
    weights, least = problem.samples.weights[kept], problem.shape.least_leaf_weight
    size = max(1, math.ceil(least / unit * (1 - 10 * BELOW)))
    times = np.clip(np.ceil(weights / unit * (1 - BELOW)), 1, size)
    times[weights >= least] = size
    rows = np.repeat(np.arange(len(kept)), times.astype(np.int64))
    is_first = np.diff(rows, prepend=-1) > 0
    weights = np.where(is_first, weights[rows], 0.0)
    return problem.of_rows(kept[rows], weights=weights, leaf_size=size, leaf_weight=None)
