"""The hyperplane of widest margin between two sets of points that some hyperplane parts.

    maximise over v    (min over R of v . z  -  max over L of v . z) / |v|

The best v joins the nearest points of the two convex hulls, sum_i a_i z_i over L and sum_j b_j z_j over R:

    minimise over a, b >= 0, sum a = sum b = 1    | sum_j b_j z_j - sum_i a_i z_i |^2

which is a non-negative least squares problem in a and b, its sums held by rows of their own. It is solved over the
points nearest to the plane, and again with those that its answer brings nearest.
Source: Lawson & Hanson (1995), Solving Least Squares Problems, ch. 23; Bennett & Bredensteiner (2000), Duality and
geometry in SVM classifiers (the hulls).
"""

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

NEAREST = 40
"""Points of each side that are looked at first, and that every round may add."""
ROUNDS = 6
EQUAL_SUMS = 1e3
"""Weight of the row that holds both sums alike, in units of the distance between the sides."""


def width(points: Floats, normal: Floats, left: NDArray[np.bool_]) -> float:
    """Return how far apart a normal (k,) holds points (n, k) of the left and of the right; negative: not parted."""
    heights, length = points @ normal, float(np.linalg.norm(normal))
    return float(heights[~left].min() - heights[left].max()) / length if length > 0 else -np.inf


def widened(points: Floats, normal: Floats, left: NDArray[np.bool_]) -> Floats:
    """Return the normal of widest margin between the points (n, k) of both sides, as far as a few rounds find it.

    It is the given one, which parts them, unless another one's margin is wider.
    """
    best, widest = normal, width(points, normal, left)
    near = np.zeros(len(points), dtype=np.bool_)
    trial = normal
    for _ in range(ROUNDS):
        nearest = _nearest(points @ trial, left)
        if near[nearest].all():
            break
        near[nearest] = True
        between = _between(points[near & left], points[near & ~left])
        if between is None:
            break
        trial = between
        trial_width = width(points, trial, left)
        if trial_width > widest:
            best, widest = trial, trial_width
    return best


def _nearest(heights: Floats, left: NDArray[np.bool_]) -> NDArray[np.intp]:
    """Return the rows of each side that lie nearest to the other side."""
    sides = np.flatnonzero(left), np.flatnonzero(~left)
    orders = np.argsort(-heights[sides[0]], kind="stable"), np.argsort(heights[sides[1]], kind="stable")
    return np.concatenate([side[order[:NEAREST]] for side, order in zip(sides, orders, strict=True)])


def _between(left: Floats, right: Floats) -> Floats | None:
    """Return the vector from the hull of the left points to that of the right ones; None where it is not found."""
    from scipy.optimize import nnls  # only here: every proof from depth 4 on would wait 0.4 s for it

    centre = (left.mean(axis=0) + right.mean(axis=0)) / 2
    scale = float(np.linalg.norm(right.mean(axis=0) - left.mean(axis=0)))
    if scale == 0.0 or not np.isfinite(scale):
        return None
    columns = np.vstack([centre - left, right - centre]).T / scale
    sign = np.concatenate([np.ones(len(left)), -np.ones(len(right))])
    system = np.vstack([columns, EQUAL_SUMS * sign, np.ones(len(sign))])
    wanted = np.zeros(len(system))
    wanted[-1] = 2.0
    try:
        shares, _ = nnls(system, wanted)
    except RuntimeError:  # too many iterations
        return None
    between: Floats = columns @ shares
    return between if between.any() and np.isfinite(between).all() else None
