"""How far apart the targets of one leaf may lie, and targets moved so near that a grid of them is fine.

Samples i and j of weight above 0 in one leaf err together by at least ``min(w_i, w_j) / 2 * (y_i - y_j)**2`` (squared
error) or ``min(w_i, w_j) * min(up, down) / over * |y_i - y_j|`` (sloped), whatever it predicts. So where a tree of
some objective is known, no better one has two targets in a leaf that lie farther apart than a *reach*. Gaps between
neighbouring targets that are longer are made as long as the reach: the targets then span no more than the errors that
decide, and one far target no longer coarsens the grid of all. Proof that bounds and better trees stay the same:
docs/theory/regression.md.
"""

import math

import numpy as np
from numpy.typing import NDArray

from octmip.trees.question.problem import Problem

Floats = NDArray[np.float64]
FARTHEST = 1100
"""No two numbers of float64 are 2 to this power apart."""


def reach(problem: Problem, objective: float) -> int:
    """Return an exponent e: a leaf with targets 2**e apart errs by more than four times this objective.

    `FARTHEST` where the objective is 0: it needs no proof.
    """
    if objective <= 0:
        return FARTHEST
    lightest = float(problem.samples.weights[problem.samples.weights > 0].min())
    slopes = problem.number_loss.slopes
    power, flattest = (2, 1.0) if slopes is None else (1, min(slopes.up, slopes.down) / slopes.over)
    return min(FARTHEST, math.ceil((math.log2(objective) - math.log2(lightest) - math.log2(flattest)) / power) + 2)


def closed_up(targets: Floats, exponent: int) -> Floats:
    """Return the targets (n_samples,) with gaps longer than twice 2**exponent made 2**exponent long.

    Twice, for then no rounding makes a gap longer than it was. Each target is rounded twice, by 2**-53 of their span.
    """
    if exponent > 1000:
        return targets
    values, places = np.unique(targets, return_inverse=True)
    most = math.ldexp(1.0, exponent)
    is_far = np.diff(values) > 2 * most
    if not is_far.any():
        return targets
    starts, ends = np.flatnonzero(np.append(True, is_far)), np.flatnonzero(np.append(is_far, True))
    lengths = values[ends] - values[starts]
    offsets = np.append(0.0, np.cumsum(lengths[:-1] + most))
    run = np.cumsum(np.append(0, is_far))
    moved: Floats = (values - values[starts][run]) + offsets[run]
    return moved[places]
