"""The question: points in the space that hyperplanes are written in, and the sets of features that a split may read."""

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import chain, combinations, combinations_with_replacement

import numpy as np
from numpy.typing import NDArray

from octmip.errors import ProblemError
from octmip.mip.blocks.heap import Heap, place
from octmip.mip.blocks.hyperplanes import (
    Space,
    choose_mu,
    space_of,
    split_at,
    tolerance_for,
    usable_features,
)
from octmip.mip.prices import Prices
from octmip.problem import Problem
from octmip.tree import HyperplaneSplit, Node

MOST_SETS = 2000
"""So many sets of features are looked at one by one; 20 features have 190 pairs and 1,140 triples."""

NOTHING = 1e-9  # a coefficient below it is none


@dataclass(frozen=True, slots=True)
class Case:
    """A part of all trees: the features that the root may read, and the labels that leaves left and right may name."""

    features: tuple[int, ...]
    labels: tuple[tuple[int, ...], tuple[int, ...]]


@dataclass(frozen=True, slots=True, eq=False)
class Question:
    """A problem with hyperplanes of few features.

    Attributes
    ----------
    problem
        the problem.
    space
        the transformed features of its samples.
    mu
        width of the band that a split leaves empty.
    sets
        the features that one split may read, none within another.
    sample
        (n_points,) one sample of each point: equal samples of one class are one point.
    code, weight
        (n_points,) class and price of each point.
    """

    problem: Problem
    space: Space
    mu: float
    sets: tuple[tuple[int, ...], ...]
    sample: NDArray[np.int64]
    code: NDArray[np.int64]
    weight: NDArray[np.float64]

    @classmethod
    def of(cls, problem: Problem, prices: Prices, known: Node, mu: float | None) -> "Question":
        """Return the question of a problem, its mu by the rule of `octmip.mip.blocks.hyperplanes` unless it is given.

        Raises
        ------
        ProblemError
            the problem has what these cuts do not speak about, or too many sets of features.
        """
        _require_answerable(problem)
        space, heap = space_of(problem), Heap(problem.depth)
        strictness = choose_mu(space, place(known, heap, problem.features), heap) if mu is None else mu
        keys = np.column_stack([problem.features, problem.codes])
        _, sample, point = np.unique(keys, axis=0, return_index=True, return_inverse=True)
        weight = np.bincount(point.ravel(), prices.weights, len(sample)).astype(np.float64)
        sample, weight = sample[weight > 0], weight[weight > 0]
        return cls(problem, space, strictness, feature_sets(problem), sample, problem.codes[sample], weight)

    def cases(self) -> dict[Case, int]:
        """Return the cases that together hold every tree, each with a price that none of its trees lies below.

        The leaves on one side of the root name 2^(depth - 1) labels at most; which side is left does not matter.
        """
        n_classes = self.problem.n_classes
        by_class = np.bincount(self.code, self.weight, n_classes)
        named = list(combinations(range(n_classes), min(2 ** (self.problem.depth - 1), n_classes)))
        pairs = list(combinations_with_replacement(named, 2))
        prices = [
            math.ceil(by_class[[k for k in range(n_classes) if k not in {*one, *two}]].sum()) for one, two in pairs
        ]
        return {
            Case(features, labels): price
            for price, labels in sorted(zip(prices, pairs, strict=True))
            for features in self.sets
        }

    def space_in(self, features: tuple[int, ...]) -> Space:
        """Return the space of the points in some features only."""
        chosen, whole = list(features), self.space
        x = whole.x[self.sample][:, chosen]
        widest = np.abs(whole.x[:, chosen]).max(axis=0).sum()
        reach = max(whole.coefficient * float(widest), 1e-3) if whole.is_integer else whole.reach
        return replace(
            whole,
            x=x,
            shift=whole.shift[chosen],
            scale=whole.scale[chosen],
            exponent=whole.exponent[chosen],
            reach=reach,
        )

    @property
    def tolerance(self) -> float:
        """Feasibility tolerance that HiGHS needs for mu."""
        return tolerance_for(self.mu)

    def split(self, features: tuple[int, ...], normal: NDArray[np.float64], middle: float) -> HyperplaneSplit | None:
        """Return a split on the problem's own features, None where it has no coefficients or float64 does not hold it.

        Parameters
        ----------
        normal, middle
            coefficients (n of `features`,) and offset on the transformed features.
        """
        whole = np.zeros(self.problem.n_features)
        whole[list(features)] = np.round(normal) if self.space.is_integer else normal * (np.abs(normal) >= NOTHING)
        return split_at(self.problem, self.space, whole, middle) if whole.any() else None


def feature_sets(problem: Problem) -> tuple[tuple[int, ...], ...]:
    """Return the largest sets of features that a split may read, in ascending order.

    Raises
    ------
    ProblemError
        there are more than `MOST_SETS`.
    """
    is_usable = usable_features(problem)
    allowed = [tuple(range(problem.n_features))] if problem.allowed_splits is None else problem.allowed_splits
    groups = [[int(j) for j in group if is_usable[int(j)]] for group in allowed]
    sizes = [min(problem.max_split_size, len(group)) for group in groups]
    n_sets = sum(math.comb(len(group), size) for group, size in zip(groups, sizes, strict=True))
    if n_sets > MOST_SETS:
        raise ProblemError(
            f"splits of {max(sizes)} features have {n_sets} sets to choose from; method 'benders' looks at {MOST_SETS} "
            "at most; choose 'flow', or fewer features by split_size or allowed_splits"
        )
    found = chain.from_iterable(combinations(group, size) for group, size in zip(groups, sizes, strict=True) if group)
    return tuple(sorted(_largest(set(found))))


def _largest(sets: set[tuple[int, ...]]) -> Iterator[tuple[int, ...]]:
    return (one for one in sets if not any(set(one) < set(other) for other in sets))


def _require_answerable(problem: Problem) -> None:
    """Refuse what the cuts do not speak about."""
    costs = np.asarray(problem.costs)
    refused = {
        "depth": (problem.depth, "1 or 2", problem.depth > 2),
        "leaf_size": (problem.leaf_size, "1", problem.leaf_size > 1),
        "leaf_penalty": (problem.leaf_penalty, "0", problem.leaf_penalty > 0),
        "sensor_budget": (problem.sensor_budget, "none", problem.sensor_budget is not None),
        "costs": ("a matrix", "none", not np.array_equal(costs, 1 - np.eye(len(costs)))),
    }
    for name, (given, expected, is_refused) in refused.items():
        if is_refused:
            raise ProblemError(
                f"method 'benders' cannot prove hyperplanes with {name} {given}; expected {expected}; choose 'flow'"
            )
