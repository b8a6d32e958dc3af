"""Coarse thresholds: a problem that may cut each feature in a few places only.

The places are quantiles of the readings, so that about as many samples lie between any two of them:

    readings      1  1  2  5  6  9      two cuts    at 1.5 and 5.5
    intervals     0  0  1  1  2  2      the feature of the coarse problem; "interval <= 0" means "reading <= 1.5"

Fewer cuts are faster to prove and learn less by heart. A tree over intervals sorts the samples as the tree over
readings that it stands for, so both have one objective; a proof over intervals is one among trees that cut there.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from octmip.trees.nodes.digits import midpoint
from octmip.trees.nodes.tree import Leaf, Node, Split
from octmip.trees.question.problem import Problem

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class Coarse:
    """A problem over intervals of the readings, and the cuts between them.

    Attributes
    ----------
    problem
        with the number of the interval in place of every reading; a missing one stays missing.
    cuts
        for each feature the places where it may be cut, ascending.
    n_cuts
        most of them in any feature.
    """

    problem: Problem
    cuts: tuple[Floats, ...]
    n_cuts: int

    @classmethod
    def of(cls, problem: Problem, n_cuts: int) -> "Coarse":
        """Return the problem over intervals with at most `n_cuts` cuts of each feature; splits are axis-aligned."""
        cuts = tuple(_cuts(column, n_cuts) for column in problem.samples.features.T)
        intervals = np.empty(problem.samples.features.shape)
        for j, (column, places) in enumerate(zip(problem.samples.features.T, cuts, strict=True)):
            intervals[:, j] = np.where(np.isnan(column), np.nan, np.searchsorted(places, column))
        return cls(problem.replace(features=intervals), cuts, n_cuts)

    @property
    def scope(self) -> str:
        """The trees that a proof over intervals is about."""
        return f"trees that cut each feature at {self.n_cuts} quantiles at most"

    def over_readings(self, tree: Node) -> Node:
        """Return the tree over readings that a tree over intervals stands for."""
        return _with_thresholds(tree, lambda split, at: float(self.cuts[split.feature][math.floor(at)]))

    def over_intervals(self, tree: Node) -> Node:
        """Return the tree over intervals that stands for a tree over readings, made by `over_readings`."""
        return _with_thresholds(tree, lambda split, at: np.searchsorted(self.cuts[split.feature], at) + 0.5)


def _with_thresholds(tree: Node, changed: Callable[[Split, float], float]) -> Node:
    if isinstance(tree, Leaf):
        return tree
    assert isinstance(tree, Split)  # no feature of a sum can be cut by itself
    threshold = None if tree.threshold is None else float(changed(tree, tree.threshold))
    left, right = _with_thresholds(tree.left, changed), _with_thresholds(tree.right, changed)
    return replace(tree, threshold=threshold, left=left, right=right)


def _cuts(column: Floats, n_cuts: int) -> Floats:
    """Return the places where a feature is cut: between all its values, or at quantiles where these are too many."""
    readings = np.sort(column[~np.isnan(column)])
    values = np.unique(readings)
    if len(values) > n_cuts + 1:
        at = readings[np.arange(1, n_cuts + 1) * len(readings) // (n_cuts + 1)]
        above = np.unique(np.maximum(np.searchsorted(values, at), 1))
    else:
        above = np.arange(1, len(values))
    return np.array([midpoint(float(values[k - 1]), float(values[k])) for k in above.tolist()])
