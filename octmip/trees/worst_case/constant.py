"""The worst constant error of gauges: the same for every sample, any float64 of the band. Imports no solver.

A sample passes a threshold where its error reaches some least float64, found by bisection. Between two such errors
nothing changes: the cost is piecewise constant in the error, in the errors of several features on a grid of boxes.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np
from numpy.typing import NDArray

from octmip.trees.problem import Problem
from octmip.trees.tree import Node, Split, predict, splits
from octmip.trees.worst_case.bands import Bands

Floats = NDArray[np.float64]

MOST_BOXES = 4_000_000
"""Boxes of errors up to which all are tried."""
NEAR = 1e-9
"""Costs this near to the largest one, relative, are recounted: they were summed with rounding."""
_MAGNITUDE = np.int64(2**63 - 1)


@dataclass(frozen=True, slots=True)
class ConstantBias:
    """The worst constant errors.

    Attributes
    ----------
    cost
        of the tree then, in units of the problem's objective.
    gauges
        that are off; () where no error makes it worse.
    errors
        of each feature that the tree reads of them, by name.
    """

    cost: float
    gauges: tuple[str, ...]
    errors: Mapping[str, float]


def worst_constant(
    problem: Problem, tree: Node, bands: Bands, sets: Sequence[tuple[str, ...]], plain: float
) -> ConstantBias | None:
    """Return the worst constant errors over sets of sensors; None where there are more than `MOST_BOXES` to try."""
    best = ConstantBias(plain, (), {})
    for gauges in sets:
        features = [f for f in sorted(_read(tree)) if problem.sensors[problem.sensor_index[f]] in gauges]
        features = [f for f in features if bands.can_be_off(f)]
        if not features:
            continue
        steps = [_steps(problem, tree, bands, f) for f in features]
        grids = [np.unique(step[np.isfinite(step)]) for step in steps]
        if math.prod(len(grid) for grid in grids) > MOST_BOXES:
            return None
        errors = _worst(problem, tree, features, steps, grids)
        cost = problem.objective_of(tree, predict(tree, _shifted(problem.features, features, errors)))
        if cost > best.cost:
            names = [problem.feature_names[f] for f in features]
            best = ConstantBias(cost, gauges, dict(zip(names, errors, strict=True)))
    return best


def _read(tree: Node) -> set[int]:
    return {split.feature for split in splits(tree) if isinstance(split, Split)}


def _steps(problem: Problem, tree: Node, bands: Bands, feature: int) -> Floats:
    """Return the error from which on each sample is beyond each threshold, (n_thresholds + 1, n_samples), +inf: never.

    The first row is the least error of the band, where all begin; thresholds ascend.
    """
    own = [s.threshold for s in splits(tree) if isinstance(s, Split) and s.feature == feature]
    # A split without a threshold asks whether the reading is missing, and none is here.
    thresholds = sorted({threshold for threshold in own if threshold is not None})
    values = problem.features[:, feature].astype(np.float64)
    least, most = -float(bands.below[feature]), float(bands.above[feature])
    return np.stack([np.full(len(values), least), *(first_beyond(values, t, least, most) for t in thresholds)])


def first_beyond(values: Floats, threshold: float, least: float, most: float) -> Floats:
    """Return the least float64 of a band by which each value, rounded, goes beyond a threshold; +inf: none does."""
    low = np.full(values.shape, _keys(np.array(least)))
    high = np.full(values.shape, _keys(np.array(most)))
    is_beyond = values + most > threshold
    while (low < high).any():
        middle = (low >> 1) + (high >> 1) + (low & high & 1)  # the difference may be beyond int64
        beyond = values + _floats(middle) > threshold
        high = np.where(beyond, middle, high)
        low = np.where(beyond, low, np.minimum(middle + 1, high))
    return np.where(is_beyond, _floats(high), np.inf)


def _keys(numbers: Floats) -> NDArray[np.int64]:
    """Return whole numbers in the order of float64 numbers, neighbours one apart."""
    bits = (numbers + 0.0).view(np.int64)
    return np.where(bits < 0, -(bits & _MAGNITUDE), bits)


def _floats(keys: NDArray[np.int64]) -> Floats:
    sizes = np.abs(keys).view(np.float64)
    return np.where(keys < 0, -sizes, sizes)


def _shifted(values: Floats, features: Sequence[int], errors: Sequence[float]) -> Floats:
    out = values.astype(np.float64)
    for feature, error in zip(features, errors, strict=True):
        out[:, feature] += error
    return out


def _worst(
    problem: Problem, tree: Node, features: Sequence[int], steps: Sequence[Floats], grids: Sequence[Floats]
) -> list[float]:
    """Return the errors, one for each feature, at which the tree costs most.

    Each sample adds its cost to every box of errors in which it stays at one leaf: differences at the corners, summed.
    """
    sums = np.zeros([len(grid) + 1 for grid in grids])
    for numbers in product(*(range(len(step)) for step in steps)):
        begins = [step[k] for step, k in zip(steps, numbers, strict=True)]
        ends = [
            step[k + 1] if k + 1 < len(step) else np.full(step.shape[1], np.inf)
            for step, k in zip(steps, numbers, strict=True)
        ]
        rows = np.flatnonzero(np.all([np.isfinite(b) & (b < e) for b, e in zip(begins, ends, strict=True)], axis=0))
        shifted = problem.features[rows].astype(np.float64)
        for feature, begin in zip(features, begins, strict=True):
            shifted[:, feature] += begin[rows]
        paid = problem.weights[rows] * problem.costs[problem.codes[rows], predict(tree, shifted)]
        sides = [
            (np.searchsorted(grid, begin[rows]), np.searchsorted(grid, end[rows]))
            for grid, begin, end in zip(grids, begins, ends, strict=True)
        ]
        for corner in product((0, 1), repeat=len(features)):
            place = tuple(side[at] for side, at in zip(sides, corner, strict=True))
            np.add.at(sums, place, paid * (-1) ** sum(corner))
    for axis in range(sums.ndim):
        sums = sums.cumsum(axis=axis)
    sums = sums[tuple(slice(0, len(grid)) for grid in grids)]
    near = np.argwhere(sums >= sums.max() - NEAR * abs(sums.max()))[:100]
    chosen = [[float(grid[k]) for grid, k in zip(grids, place, strict=True)] for place in near]
    return max(
        chosen,
        key=lambda errors: problem.objective_of(tree, predict(tree, _shifted(problem.features, features, errors))),
    )
