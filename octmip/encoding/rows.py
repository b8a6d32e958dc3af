"""A tree as the native core's table of nodes, and back."""

from collections.abc import Sequence

import numpy as np

from octmip.encoding.ranks import Ranks
from octmip.tree import HyperplaneSplit, Leaf, Node, Split, midpoint

# One node of the native core's table, preorder, root first:
# (kind 0 leaf | 1 split | 2 hyperplane, feature, cut, left, right, label, [(feature, coefficient)], offset)
NodeRow = tuple[int, int, int, int, int, int, list[tuple[int, float]], float]


def tree_from_rows(rows: Sequence[NodeRow], ranks: Ranks) -> Node:
    """Return the tree that a native node table stands for, thresholds at guarded midpoints."""

    def build(index: int) -> Node:
        kind, feature, cut, left, right, label, terms, offset = rows[index]
        if kind == 0:
            return Leaf(label)
        if kind == 1:
            values = ranks.values[feature]
            return Split(feature, midpoint(float(values[cut]), float(values[cut + 1])), build(left), build(right))
        ordered = sorted(terms)
        features, coefficients = tuple(f for f, _ in ordered), tuple(c for _, c in ordered)
        return HyperplaneSplit(features, coefficients, offset, build(left), build(right))

    return build(0)


def rows_from_tree(tree: Node, ranks: Ranks) -> list[NodeRow]:
    """Return the native node table of a tree; a threshold outside the data's range becomes the nearest cut."""
    rows: list[NodeRow] = []

    def add(node: Node) -> int:
        index = len(rows)
        rows.append((0, 0, 0, 0, 0, 0, [], 0.0))
        if isinstance(node, Leaf):
            rows[index] = (0, 0, 0, 0, 0, node.label, [], 0.0)
            return index
        left, right = add(node.left), add(node.right)
        if isinstance(node, Split):
            # Trees whose sides all hold samples (see `tree.without_empty_sides`) have 0 <= cut < number of values - 1.
            cut = int(np.searchsorted(ranks.values[node.feature], node.threshold, side="right")) - 1
            rows[index] = (1, node.feature, cut, left, right, 0, [], 0.0)
        else:
            terms = list(zip(node.features, node.coefficients, strict=True))
            rows[index] = (2, 0, 0, left, right, 0, terms, node.offset)
        return index

    add(tree)
    return rows
