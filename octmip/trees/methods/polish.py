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
from dataclasses import dataclass, replace
from typing import Self

import numpy as np
from numpy.typing import NDArray

from octmip.trees.methods.margin import widened, width
from octmip.trees.nodes.digits import midpoint
from octmip.trees.nodes.tree import HyperplaneSplit, Leaf, Node, goes_left
from octmip.trees.question.problem import Problem

MOST_DIGITS = 6
KEPT = 0.9
"""Share of the widest margin that rounding must keep."""
MODERATE = (1e-100, 1e100)
"""Features whose largest value lies between these are polished as they are: no square of them overflows."""
MODERATE_EXPONENT = 500
"""Coefficients below two to this power, and above one over that, are left as they are."""
Floats = NDArray[np.float64]
GoesOn = Callable[[], bool]


def polished(problem: Problem, tree: Node, goes_on: GoesOn = lambda: True) -> Node:
    """Return a tree that sends every sample of the problem where `tree` does, with simpler hyperplanes.

    Planes stay as they are once `goes_on` says no, and where simpler ones could overflow on some sample of the problem.
    """
    largest = np.abs(problem.samples.features).max(axis=0)
    return _polished(_Polish(problem, largest, goes_on), tree, np.arange(problem.samples.n_samples))


@dataclass(frozen=True, slots=True, eq=False)
class _Polish:
    """The context of polishing: the problem, the largest value of each of its features, and whether to go on."""

    problem: Problem
    largest: Floats
    goes_on: GoesOn

    def overflows(self, terms: list[tuple[int, float]]) -> bool:
        """Whether the sum of these products could overflow on a sample of the problem."""
        return not math.isfinite(sum(abs(c) * float(self.largest[f]) for f, c in terms))


def _polished(polish: _Polish, tree: Node, rows: NDArray[np.intp]) -> Node:
    if isinstance(tree, Leaf):
        return tree
    features = polish.problem.samples.features
    left = goes_left(tree, features[rows])
    if isinstance(tree, HyperplaneSplit) and left.any() and not left.all() and polish.goes_on():
        tree = _simpler(polish, tree, features[rows], left)
        left = goes_left(tree, features[rows])
    return replace(
        tree,
        left=_polished(polish, tree.left, rows[left]),
        right=_polished(polish, tree.right, rows[~left]),
    )


@dataclass(frozen=True, slots=True, eq=False)
class _Units:
    """A split's samples and normal with each feature that is not of moderate size in a power of two of its own.

    Attributes
    ----------
    samples
        (n_samples, n_terms); no square of them overflows, and they part as the values as given do.
    normal
        (n_terms,).
    exponents
        (n_terms,): the sample's values are those here times two to this power.
    """

    samples: Floats
    normal: Floats
    exponents: NDArray[np.int64]

    @classmethod
    def of(cls, values: Floats, coefficients: tuple[float, ...]) -> Self:
        """Return the units of values (n_samples, n_terms) and the coefficients of a split over them."""
        largest = np.abs(values).max(axis=0)
        is_moderate = (largest == 0.0) | ((largest > MODERATE[0]) & (largest < MODERATE[1]))
        exponents = np.where(is_moderate, 0, np.frexp(largest)[1]).astype(np.int64)
        mantissas, powers = np.frexp(np.array(coefficients, dtype=np.float64))
        return cls(np.ldexp(values, -exponents), _balanced(mantissas, powers + exponents), exponents)

    def given(self, normal: Floats) -> Floats:
        """Return a normal in the units of the values as given."""
        mantissas, powers = np.frexp(normal)
        return _balanced(mantissas, np.where(normal == 0.0, 0, powers - self.exponents))


def _balanced(mantissas: Floats, powers: NDArray[np.int64]) -> Floats:
    """Return mantissas times powers of two, all shifted alike where some would come near the ends of the range.

    Those of a range too wide for float64 become infinite at one end and zero at the other.
    """
    used = powers[mantissas != 0.0]
    is_moderate = len(used) == 0 or int(np.abs(used).max()) <= MODERATE_EXPONENT
    shift = 0 if is_moderate else -(int(used.max()) + int(used.min())) // 2
    with np.errstate(over="ignore"):
        return np.ldexp(mantissas, powers + shift)


def _simpler(polish: _Polish, split: HyperplaneSplit, samples: Floats, left: NDArray[np.bool_]) -> HyperplaneSplit:
    """Return the split with fewer features, a wider margin and fewer digits."""
    units = _Units.of(samples[:, list(split.features)], split.coefficients)
    if not np.isfinite(units.normal).all():
        return split
    normal = _without_idle_features(polish, units, left)
    if polish.problem.shape.integer_normals is not None:
        normal = np.where(normal == 0.0, 0.0, split.coefficients)
    elif polish.goes_on():
        normal = units.given(_wide_and_short(units.samples, normal, left))
    else:
        normal = units.given(normal)
    return _split_of(polish, split, normal, samples, left)


def _without_idle_features(polish: _Polish, units: _Units, left: NDArray[np.bool_]) -> Floats:
    """Return the normal without the features that parting the samples does not need, the least ones first."""
    normal, spread = units.normal, units.samples.std(axis=0)
    for k in np.argsort(np.abs(normal) * spread, kind="stable"):
        if not polish.goes_on():
            break
        trial = normal.copy()
        trial[k] = 0.0
        if trial.any() and _gap(units.samples @ trial, left) is not None:
            normal = trial
    return normal


def _wide_and_short(samples: Floats, normal: Floats, left: NDArray[np.bool_]) -> Floats:
    """Return the normal of widest margin over the features of `normal`, in few digits, where that parts alike."""
    kept = np.flatnonzero(normal)
    spread = samples[:, kept].std(axis=0)
    spread[spread == 0.0] = 1.0
    points = (samples[:, kept] - samples[:, kept].mean(axis=0)) / spread
    weights = _of_size_one(normal[kept] * spread)
    if not weights.all():
        return normal
    wide = widened(points, weights, left) / spread if len(kept) > 1 else normal[kept]
    found = normal.copy()
    found[kept] = wide
    if _gap(samples @ found, left) is None:
        found = normal
    least = KEPT * width(points, _of_size_one(found[kept] * spread), left)
    return _short(samples, found, left, lambda trial: width(points, _of_size_one(trial[kept] * spread), left) >= least)


def _of_size_one(normal: Floats) -> Floats:
    """Return the normal divided by the power of two that brings its largest coefficient to between a half and 1."""
    return np.ldexp(normal, -int(np.frexp(np.abs(normal).max())[1]))


def _short(samples: Floats, normal: Floats, left: NDArray[np.bool_], is_wide: Callable[[Floats], bool]) -> Floats:
    """Return the normal, its largest coefficient 1, in as few digits as part the samples alike and widely."""
    scaled = normal / np.abs(normal).max()
    for digits in range(1, MOST_DIGITS + 1):
        rounded = np.array([float(f"{c:.{digits}g}") for c in scaled])
        if _gap(samples @ rounded, left) is not None and is_wide(rounded):
            return rounded
    return normal


def _split_of(
    polish: _Polish, split: HyperplaneSplit, normal: Floats, samples: Floats, left: NDArray[np.bool_]
) -> HyperplaneSplit:
    """Return the split of a normal, or the given one where rounding makes the two part differently."""
    terms = [(f, float(c)) for f, c in zip(split.features, normal, strict=True) if c != 0.0]
    gap = None if polish.overflows(terms) else _gap(_projected(terms, samples), left)
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
    middle = midpoint(highest, lowest)
    sixth = lowest / 6 - highest / 6
    if sixth == 0.0:
        return middle
    rounded = round(middle, max(0, math.ceil(-math.log10(sixth))))
    return rounded if abs(rounded - middle) <= sixth else middle
