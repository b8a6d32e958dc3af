"""Simpler hyperplanes that part the training samples as before: fewer features, shorter numbers, the offset in mid-gap.

A split `w . x <= b` parts the samples of its node into left L and right R. Any other normal v with

    max over L of v . x  <  min over R of v . x

parts them alike, with an offset between the two. So every leaf keeps its samples, and the objective cannot change but
for a penalty on features, which falls with them. Looked for in turn: v without one of the features, the one that
weighs least first; of the features left, the v of widest margin (`margin.py`), each feature in units of its spread over
the node's samples; v rounded to the fewest digits that keep nine tenths of that margin; and of its offsets the middle.
Integer normals stay as they are but for features that go.
"""

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from octmip.margin import widened, width
from octmip.problem import Problem
from octmip.tree import HyperplaneSplit, Leaf, Node, goes_left

MOST_DIGITS = 6
KEPT = 0.9
"""Share of the widest margin that rounding must keep."""
Floats = NDArray[np.float64]


def polished(problem: Problem, tree: Node) -> Node:
    """Return a tree that sends every sample of the problem where `tree` does, with simpler hyperplanes."""
    return _polished(problem, tree, np.arange(problem.n_samples))


def _polished(problem: Problem, tree: Node, rows: NDArray[np.intp]) -> Node:
    if isinstance(tree, Leaf):
        return tree
    left = goes_left(tree, problem.features[rows])
    if isinstance(tree, HyperplaneSplit) and left.any() and not left.all():
        tree = _simpler(problem, tree, problem.features[rows], left)
        left = goes_left(tree, problem.features[rows])
    return replace(
        tree,
        left=_polished(problem, tree.left, rows[left]),
        right=_polished(problem, tree.right, rows[~left]),
    )


def _simpler(problem: Problem, split: HyperplaneSplit, samples: Floats, left: NDArray[np.bool_]) -> HyperplaneSplit:
    """Return the split with fewer features, a wider margin and fewer digits."""
    features, normal = list(split.features), np.array(split.coefficients, dtype=np.float64)
    spread = samples[:, features].std(axis=0)
    for k in np.argsort(np.abs(normal) * spread, kind="stable"):
        trial = normal.copy()
        trial[k] = 0.0
        if trial.any() and _gap(samples[:, features] @ trial, left) is not None:
            normal = trial
    if problem.integer_normals is None:
        normal = _wide_and_short(samples[:, features], normal, left)
    return _split_of(split, features, normal, samples, left)


def _wide_and_short(samples: Floats, normal: Floats, left: NDArray[np.bool_]) -> Floats:
    """Return the normal of widest margin over the features of `normal`, in few digits, where that parts alike."""
    kept = np.flatnonzero(normal)
    spread = samples[:, kept].std(axis=0)
    spread[spread == 0.0] = 1.0
    points = (samples[:, kept] - samples[:, kept].mean(axis=0)) / spread
    wide = widened(points, normal[kept] * spread, left) / spread if len(kept) > 1 else normal[kept]
    found = normal.copy()
    found[kept] = wide
    if _gap(samples @ found, left) is None:
        found = normal
    least = KEPT * width(points, found[kept] * spread, left)
    return _short(samples, found, left, lambda trial: width(points, trial[kept] * spread, left) >= least)


def _short(samples: Floats, normal: Floats, left: NDArray[np.bool_], is_wide: Callable[[Floats], bool]) -> Floats:
    """Return the normal, its largest coefficient 1, in as few digits as part the samples alike and widely."""
    scaled = normal / np.abs(normal).max()
    for digits in range(1, MOST_DIGITS + 1):
        rounded = np.array([float(f"{c:.{digits}g}") for c in scaled])
        if _gap(samples @ rounded, left) is not None and is_wide(rounded):
            return rounded
    return normal


def _split_of(
    split: HyperplaneSplit, features: list[int], normal: Floats, samples: Floats, left: NDArray[np.bool_]
) -> HyperplaneSplit:
    """Return the split of a normal, or the given one where rounding makes the two part differently."""
    terms = [(f, float(c)) for f, c in zip(features, normal, strict=True) if c != 0.0]
    gap = _gap(_projected(terms, samples), left)
    if gap is None:
        return split
    trial = replace(
        split,
        features=tuple(f for f, _ in terms),
        coefficients=tuple(c for _, c in terms),
        offset=_middle(*gap),
    )
    return trial if np.array_equal(goes_left(trial, samples), left) else split


def _projected(terms: list[tuple[int, float]], samples: Floats) -> Floats:
    total = np.zeros(len(samples))
    for feature, coefficient in terms:
        total += coefficient * samples[:, feature]
    return total


def _gap(heights: Floats, left: NDArray[np.bool_]) -> tuple[float, float] | None:
    """Return the highest on the left and the lowest on the right; None unless there is room between them."""
    highest, lowest = float(heights[left].max()), float(heights[~left].min())
    room = 1e-9 * max(abs(highest), abs(lowest))
    return (highest, lowest) if lowest - highest > room else None


def _middle(highest: float, lowest: float) -> float:
    """Return the shortest decimal in the middle third of a gap."""
    middle = highest / 2 + lowest / 2
    width = lowest - highest
    rounded = round(middle, max(0, math.ceil(-math.log10(width / 6))) if width > 0 else 0)
    return rounded if abs(rounded - middle) <= width / 6 else middle
