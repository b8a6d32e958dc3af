"""Every tree of a tiny axis-aligned problem, laid into the complete tree that formulations are written over.

A node without a split sends all samples to its right. Every side of a split holds samples; every leaf has a label that
costs least there.
Knows no formulation and no solver.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import product

import numpy as np

from octmip.trees.nodes.tree import Leaf, Node, Split
from octmip.trees.question.problem import Problem


@dataclass(frozen=True, slots=True)
class HeapTree:
    """A tree over numbered nodes: the children of m are 2 m and 2 m + 1.

    Attributes
    ----------
    splits
        (feature, number of the feature's values that go left) by node.
    leaves
        (rows, label) by leaf of the complete tree.
    cost
        of its predictions and splits.
    """

    splits: dict[int, tuple[int, int]]
    leaves: dict[int, tuple[frozenset[int], int]]
    cost: float


def heap_trees(problem: Problem) -> Iterator[HeapTree]:
    """Yield every tree of a problem whose sides hold `leaf_size` samples or more; a leaf has a class of least cost."""
    n_values = [np.unique(column, return_inverse=True)[1] for column in problem.samples.features.T]
    depth, prices = int(problem.shape.depth), problem.samples.weights[:, None] * problem.cost_table[problem.cost_rows]
    for splits, leaves in _below(problem, n_values, 1, frozenset(range(problem.samples.n_samples)), depth):
        costs = [prices[sorted(rows)].sum(axis=0) for _, rows in leaves]
        for labels in product(*(np.flatnonzero(cost == cost.min()).tolist() for cost in costs)):
            placed = {t: (rows, label) for (t, rows), label in zip(leaves, labels, strict=True)}
            cost = sum(cost.min() for cost in costs) + problem.shape.leaf_penalty * len(splits)
            yield HeapTree(dict(splits), placed, float(cost))


Shape = tuple[list[tuple[int, tuple[int, int]]], list[tuple[int, frozenset[int]]]]


def _below(problem: Problem, ranks: list[np.ndarray], m: int, rows: frozenset[int], depth: int) -> Iterator[Shape]:
    """Yield the splits and leaves below node m, which has `depth` levels of splits."""
    yield [], [((m + 1) * 2**depth - 1, rows)]
    for feature, of_row in enumerate(ranks) if depth else ():
        for n_left in sorted({int(of_row[i]) for i in rows})[1:]:
            left = frozenset(i for i in rows if of_row[i] < n_left)
            if min(len(left), len(rows - left)) < problem.shape.leaf_size:
                continue
            for one in _below(problem, ranks, 2 * m, left, depth - 1):
                for other in _below(problem, ranks, 2 * m + 1, rows - left, depth - 1):
                    yield [(m, (feature, n_left)), *one[0], *other[0]], [*one[1], *other[1]]


def heap_tree(problem: Problem, tree: Node) -> HeapTree:
    """Return a tree as `heap_trees` has it."""
    values = [np.unique(column) for column in problem.samples.features.T]
    splits: dict[int, tuple[int, int]] = {}
    leaves: dict[int, tuple[frozenset[int], int]] = {}

    def lay(node: Node, m: int, rows: frozenset[int], depth: int) -> None:
        if isinstance(node, Leaf):
            leaves[(m + 1) * 2**depth - 1] = rows, node.label
            return
        assert isinstance(node, Split)
        left = frozenset(i for i in rows if problem.samples.features[i, node.feature] <= node.threshold)
        above = [problem.samples.features[i, node.feature] for i in rows - left]
        splits[m] = node.feature, int(np.searchsorted(values[node.feature], min(above))) if above else -1
        lay(node.left, 2 * m, left, depth - 1)
        lay(node.right, 2 * m + 1, rows - left, depth - 1)

    lay(tree, 1, frozenset(range(problem.samples.n_samples)), int(problem.shape.depth))
    return HeapTree(splits, leaves, problem.objective(tree))
