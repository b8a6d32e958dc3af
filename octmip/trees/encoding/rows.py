"""A tree as the native core's table of nodes, and back: the one place that knows columns and sides.

A cut of a column that ranks missing readings below the others (or above) is a split that sends them left (right); the
cut between missing readings and the others is the split that asks for nothing else.
"""

from collections.abc import Sequence
from typing import TypedDict, final

import numpy as np

from octmip.trees.encoding.ranks import Ranks
from octmip.trees.tree import HyperplaneSplit, Leaf, Node, Split, midpoint


@final
class LeafRow(TypedDict):
    """A leaf of the native core's table."""

    label: int


@final
class SplitRow(TypedDict):
    """A split at a rank: as much and less goes left. `left` and `right` are the children's rows, further down."""

    feature: int
    cut: int
    left: int
    right: int


@final
class HyperplaneRow(TypedDict):
    """A split by a hyperplane, its terms (feature, coefficient)."""

    terms: list[tuple[int, float]]
    offset: float
    left: int
    right: int


NodeRow = LeafRow | SplitRow | HyperplaneRow
"""One node of the native core's table, in preorder, the root first."""


def tree_from_rows(rows: Sequence[NodeRow], ranks: Ranks) -> Node:
    """Return the tree that a native node table stands for, thresholds at guarded midpoints."""

    def build(index: int) -> Node:
        row = rows[index]
        if "label" in row:
            return Leaf(row["label"])
        left, right = build(row["left"]), build(row["right"])
        if "cut" in row:
            return cut_as_split(ranks, row["feature"], row["cut"], left, right)
        features, coefficients = zip(*sorted(row["terms"]), strict=True)
        return HyperplaneSplit(features, coefficients, row["offset"], left, right)

    return build(0)


def cut_as_split(ranks: Ranks, column: int, cut: int, left: Node, right: Node) -> Split:
    """Return the split that a cut of a column stands for, its threshold a guarded midpoint."""
    threshold = threshold_of_cut(ranks, column, cut)
    return Split(ranks.feature(column), threshold, left, right, missing=ranks.side(column))


def threshold_of_cut(ranks: Ranks, column: int, cut: int) -> float | None:
    """Return the guarded midpoint that a cut of a column stands for; None where it asks "is the reading missing?"."""
    values = ranks.values[column]
    low, high = float(values[cut]), float(values[cut + 1])
    return None if low == -np.inf or high == np.inf else midpoint(low, high)


def split_as_cut(ranks: Ranks, split: Split) -> tuple[int, int]:
    """Return the column and the cut of a split: the rank of the largest value on its left.

    A threshold outside the data's range is the nearest cut, or none: -1, or the last rank.
    """
    columns = ranks.columns_of(split.feature)
    column = next((column for column in columns if ranks.side(column) == split.missing), columns[0])
    values = ranks.values[column]
    if split.threshold is None:
        last = len(values) - 1
        # Where no reading is missing, or every one is, such a split parts nothing.
        has_gap = split.missing == ranks.side(column)
        return column, (0 if has_gap else -1) if split.missing == "left" else (last - 1 if has_gap else last)
    return column, int(np.searchsorted(values, split.threshold, side="right")) - 1


def rows_from_tree(tree: Node, ranks: Ranks) -> list[NodeRow]:
    """Return the native node table of a tree; a threshold outside the data's range becomes the nearest cut."""
    rows: list[NodeRow] = []

    def add(node: Node) -> int:
        index = len(rows)
        rows.append({"label": node.label if isinstance(node, Leaf) else 0})
        if isinstance(node, Leaf):
            return index
        left, right = add(node.left), add(node.right)
        if isinstance(node, Split):
            # Trees whose sides all hold samples (see `tree.without_empty_sides`) have 0 <= cut < number of values - 1.
            feature, cut = split_as_cut(ranks, node)
            rows[index] = {"feature": feature, "cut": cut, "left": left, "right": right}
        else:
            terms = list(zip(node.features, node.coefficients, strict=True))
            rows[index] = {"terms": terms, "offset": node.offset, "left": left, "right": right}
        return index

    add(tree)
    return rows
