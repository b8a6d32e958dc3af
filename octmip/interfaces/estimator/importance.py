"""The importance of a column: its share of what the splits of the tree save of the training cost.

With C(t) the least cost of the samples in node t under one answer, weights and costs as in training, a split of node t
into l and r saves C(t) - C(l) - C(r), which is never below 0. All splits together save what the whole tree saves
against a single leaf. A hyperplane's saving is divided among its features by |coefficient| times the standard
deviation of the feature in the node, which no change of units alters. A split that saves nothing by itself, and only
opens the way for others below it, counts nothing.

Source: L. Breiman, J. Friedman, R. Olshen, C. Stone, Classification and Regression Trees (1984), section 5.3.4, with
the cost of the tree in place of an impurity.
"""

import numpy as np
from numpy.typing import NDArray

from octmip.trees.nodes.tree import HyperplaneSplit, Leaf, Node, Split, goes_left
from octmip.trees.question.problem import Problem


def feature_savings(problem: Problem, tree: Node) -> NDArray[np.float64]:
    """Return what the splits on each feature of a problem save of the training cost, shape (n_features,)."""
    saved = np.zeros(problem.samples.n_features)
    stack: list[tuple[Node, NDArray[np.int64]]] = [(tree, np.arange(problem.samples.n_samples))]
    while stack:
        node, rows = stack.pop()
        if isinstance(node, Leaf):
            continue
        left = goes_left(node, problem.samples.features, rows)
        sides = rows[left], rows[~left]
        saving = _cost(problem, rows) - sum(_cost(problem, side) for side in sides)
        saved[list(node.features)] += max(0.0, saving) * _shares(problem, node, rows)
        stack += [(node.left, sides[0]), (node.right, sides[1])]
    return saved


def _cost(problem: Problem, rows: NDArray[np.int64]) -> float:
    return problem.leaf_and_cost(rows)[1]


def _shares(problem: Problem, node: Split | HyperplaneSplit, rows: NDArray[np.int64]) -> NDArray[np.float64]:
    """Return the share of each feature of a split in its saving."""
    if isinstance(node, Split):
        return np.ones(1)
    spread = problem.samples.features[rows][:, list(node.features)].std(axis=0)
    moved = np.abs(node.coefficients) * spread
    return np.asarray(moved / moved.sum()) if moved.sum() > 0 else np.full(len(moved), 1 / len(moved))
