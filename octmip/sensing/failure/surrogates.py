"""Surrogate splits: at every split, questions to other sensors that separate the samples most like it.

When the reading of a split is missing, the first surrogate whose reading is at hand says which way; when none is, the
larger side. A surrogate stands in only if it agrees with the split more often than the larger side does.
Source: L. Breiman, J. Friedman, R. Olshen, C. Stone, Classification and Regression Trees (1984), section 5.3.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from octmip.errors import DataError
from octmip.problem import Problem
from octmip.problem_values import refuse_gaps
from octmip.tree import HyperplaneSplit, Leaf, Node, Split, goes_left, midpoint

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Surrogate:
    """A question to another sensor: left when ``x[feature] <= threshold``, or the other way round.

    Attributes
    ----------
    agreement
        share of the node's sample weight that it sends the way of the split.
    """

    feature: int
    threshold: float
    is_reversed: bool
    agreement: float


@dataclass(frozen=True, slots=True)
class GuardedSplit:
    """A split with its surrogates, best first, and the side to take when none can be asked."""

    split: Split | HyperplaneSplit
    surrogates: tuple[Surrogate, ...]
    larger_is_left: bool
    left: "GuardedNode"
    right: "GuardedNode"


GuardedNode = Leaf | GuardedSplit


@dataclass(frozen=True, slots=True)
class GuardedTree:
    """A tree that classifies readings with gaps.

    Attributes
    ----------
    root
        its nodes with surrogates.
    tree
        the tree itself; without gaps both predict the same.
    """

    root: GuardedNode
    tree: Node

    def predict(self, features: Floats) -> NDArray[np.int64]:
        """Return the class index of every row of features (n, n_features), NaN where a reading is missing.

        Raises
        ------
        DataError
            the features are no table, or hold an infinite number.
        """
        if features.ndim != 2 or np.isinf(features).any():
            raise DataError(
                f"features has shape {features.shape} or an infinite entry; expected (n, n_features), "
                "finite or NaN; correct it"
            )
        out = np.zeros(len(features), dtype=np.int64)
        stack: list[tuple[GuardedNode, NDArray[np.int64]]] = [(self.root, np.arange(len(features)))]
        while stack:
            node, rows = stack.pop()
            if isinstance(node, Leaf):
                out[rows] = node.label
                continue
            left = _left(node, features[rows])
            stack += [(node.left, rows[left]), (node.right, rows[~left])]
        return out

    def as_dict(self, feature_names: Sequence[str], class_names: Sequence[Any]) -> dict[str, Any]:
        """Return the tree with its surrogates as JSON values, by names."""
        return _as_dict(self.root, feature_names, class_names)


def _left(node: GuardedSplit, features: Floats) -> NDArray[np.bool_]:
    left = np.full(len(features), node.larger_is_left)
    is_open = np.isnan(features[:, list(node.split.features)]).any(axis=1)
    left[~is_open] = goes_left(node.split, features[~is_open])
    for surrogate in node.surrogates:
        values = features[:, surrogate.feature]
        rows = is_open & ~np.isnan(values)
        left[rows] = (values[rows] <= surrogate.threshold) != surrogate.is_reversed
        is_open = is_open & ~rows
    return left


def _as_dict(node: GuardedNode, features: Sequence[str], classes: Sequence[Any]) -> dict[str, Any]:
    if isinstance(node, Leaf):
        return {"label": classes[node.label]}
    split = node.split
    if isinstance(split, Split):
        own: dict[str, Any] = {"feature": features[split.feature], "threshold": split.threshold}
    else:
        names = [features[j] for j in split.features]
        own = {"features": names, "coefficients": list(split.coefficients), "offset": split.offset}
    own["surrogates"] = [
        {
            "feature": features[s.feature],
            "left_if": "above" if s.is_reversed else "at most",
            "threshold": s.threshold,
            "agreement": s.agreement,
        }
        for s in node.surrogates
    ]
    own["otherwise"] = "left" if node.larger_is_left else "right"
    return own | {"left": _as_dict(node.left, features, classes), "right": _as_dict(node.right, features, classes)}


def with_surrogates(problem: Problem, tree: Node, n_surrogates: int = 5) -> GuardedTree:
    """Return the tree with up to `n_surrogates` surrogates per split, each of another sensor, learnt from the problem.

    Every sensor of the problem may stand in, so also those that the tree does not read: their readings must be at hand
    in service.
    """
    why = "surrogates stand in for readings of a tree that was trained on all of them"
    refuse_gaps(problem.n_missing, why, "use the tree as it is: each split has a side for missing readings")
    return GuardedTree(_guarded(problem, tree, np.arange(problem.n_samples), n_surrogates), tree)


def _guarded(problem: Problem, node: Node, rows: NDArray[np.int64], most: int) -> GuardedNode:
    if isinstance(node, Leaf):
        return node
    left = goes_left(node, problem.features, rows)
    weights = problem.weights[rows]
    larger_is_left = bool(weights[left].sum() >= weights[~left].sum())
    own = {int(problem.sensor_index[j]) for j in node.features}
    best: dict[int, Surrogate] = {}
    for feature in range(problem.n_features):
        sensor = int(problem.sensor_index[feature])
        if sensor in own or not problem.is_allowed((feature,)):
            continue
        found = _surrogate(problem.features[rows, feature], left, weights, feature)
        if found is not None and (sensor not in best or found.agreement > best[sensor].agreement):
            best[sensor] = found
    ranked = sorted(best.values(), key=lambda s: (-s.agreement, s.feature))[:most]
    sides = (_guarded(problem, node.left, rows[left], most), _guarded(problem, node.right, rows[~left], most))
    return GuardedSplit(node, tuple(ranked), larger_is_left, *sides)


def _surrogate(values: Floats, left: NDArray[np.bool_], weights: Floats, feature: int) -> Surrogate | None:
    """Return the threshold on `values` that agrees best with `left`, None when the larger side agrees as often."""
    order = np.argsort(values, kind="stable")
    ordered = values[order]
    total = float(weights.sum())
    ends = np.flatnonzero(ordered[:-1] < ordered[1:])
    if total == 0 or len(ends) == 0:
        return None
    signed = np.where(left[order], weights[order], -weights[order])
    # Left up to the end of each run and right beyond it agree; the other way round the rest does.
    agreeing = np.cumsum(signed)[ends] + float(weights[~left].sum())
    straight, turned = int(agreeing.argmax()), int(agreeing.argmin())
    is_reversed = total - agreeing[turned] > agreeing[straight]
    end = turned if is_reversed else straight
    agreement = (total - agreeing[turned] if is_reversed else agreeing[straight]) / total
    if agreement <= max(float(weights[left].sum()), float(weights[~left].sum())) / total:
        return None
    threshold = midpoint(float(ordered[ends[end]]), float(ordered[ends[end] + 1]))
    return Surrogate(feature, threshold, bool(is_reversed), float(agreement))
