"""Monotone trees: whether predictions keep the order of some features, by the definition alone.

A tree is monotone in feature j when, of any two points that differ in feature j alone, the one with more of it gets
no lower prediction (direction 1; -1: no higher one). Each leaf is a box of points, so the tree is monotone in j where
every two leaves whose boxes overlap in all other features are in order along j.
"""

import math
from collections.abc import Iterator, Sequence
from itertools import combinations

from octmip.trees.tree import HyperplaneSplit, Leaf, Node, ValueLeaf

Box = dict[int, tuple[float, float]]
"""Of each feature that is split above a leaf: more than the first number, at most the second."""
EVERYWHERE = (-math.inf, math.inf)


def disorder(tree: Node, directions: Sequence[int]) -> tuple[int, int, int] | None:
    """Return two leaves that are out of order (numbered from the left), the nearest two, and the feature; or None."""
    return min(_disorders(tree, directions), key=lambda found: (found[1] - found[0], found), default=None)


def _disorders(tree: Node, directions: Sequence[int]) -> Iterator[tuple[int, int, int]]:
    leaves = _boxes(tree, {})
    for (i, (one, first)), (j, (other, second)) in combinations(enumerate(leaves), 2):
        parting = _parting(one, other)
        if parting is None or not directions[parting[0]]:
            continue
        feature, is_below = parting
        rise = (_value(second) - _value(first)) * directions[feature]
        if (rise if is_below else -rise) < 0:
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
