"""Monotone trees: whether predictions keep the order of some features, by the definition alone.

A tree is monotone in feature j when, of any two points that differ in feature j alone, the one with more of it gets
no lower prediction (direction 1; -1: no higher one). Each leaf is a box of points, so the tree is monotone in j where
every two leaves whose boxes overlap in all other features are in order along j.
"""

import math
from collections.abc import Iterator, Sequence
from itertools import combinations

from octmip.trees.nodes.tree import HyperplaneSplit, Leaf, Node, ValueLeaf

Box = dict[int, tuple[float, float]]
"""Of each feature that is split above a leaf: more than the first number, at most the second."""
EVERYWHERE = (-math.inf, math.inf)


def disorder(tree: Node, directions: Sequence[int]) -> tuple[int, int, int] | None:
    """Return two leaves that are out of order (numbered from the left), the nearest two, and the feature; or None."""
    return min(_disorders(tree, directions), key=lambda found: (found[1] - found[0], found), default=None)


def n_disorders(tree: Node, directions: Sequence[int]) -> int:
    """Return how many pairs of leaves are out of order."""
    return sum(1 for _ in _disorders(tree, directions))


def ordered_pairs(tree: Node, directions: Sequence[int]) -> Iterator[tuple[int, int, int, int]]:
    """Yield leaves i < j (from the left) that must be in order, the feature, and 1 where j may not predict less, -1."""
    leaves = _boxes(tree, {})
    for (i, (one, _)), (j, (other, _)) in combinations(enumerate(leaves), 2):
        parting = _parting(one, other)
        if parting is not None and directions[parting[0]]:
            feature, is_below = parting
            yield i, j, feature, directions[feature] if is_below else -directions[feature]


def _disorders(tree: Node, directions: Sequence[int]) -> Iterator[tuple[int, int, int]]:
    values = [_value(leaf) for _, leaf in _boxes(tree, {})]
    for i, j, feature, way in ordered_pairs(tree, directions):
        if (values[j] - values[i]) * way < 0:
            yield i, j, feature


def _value(leaf: Leaf) -> float:
    return leaf.value if isinstance(leaf, ValueLeaf) else leaf.label


def _parting(one: Box, other: Box) -> tuple[int, bool] | None:
    """Return the one feature in which two boxes do not overlap, and whether the first lies below; None for more."""
    found = None
    for feature in one.keys() & other.keys():
        (a, b), (c, d) = one[feature], other[feature]
        if b <= c or d <= a:
            if found is not None:
                return None
            found = feature, b <= c
    return found


def _boxes(tree: Node, box: Box) -> list[tuple[Box, Leaf]]:
    if isinstance(tree, Leaf):
        return [(box, tree)]
    assert not isinstance(tree, HyperplaneSplit)
    assert tree.threshold is not None
    low, high = box.get(tree.feature, EVERYWHERE)
    left = box | {tree.feature: (low, min(high, tree.threshold))}
    right = box | {tree.feature: (max(low, tree.threshold), high)}
    return _boxes(tree.left, left) + _boxes(tree.right, right)
