"""Heap: the complete binary tree over which a formulation is written, and trees laid into it.

Nodes are numbered as in a heap, so the children of m are 2m (left) and 2m + 1 (right). Depth 2:

             1
         2       3          branch nodes T_B = 1 2 3
       4   5   6   7        leaves       T_L = 4 5 6 7

A node of T_B without a split sends every sample to the right: a leaf of the tree sits at the rightmost leaf below it.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from octmip.errors import TreeError
from octmip.trees.nodes.tree import HyperplaneSplit, Leaf, Node, Split, depth, goes_left


@dataclass(frozen=True, slots=True)
class Heap:
    """A complete binary tree of `depth` levels of branch nodes."""

    depth: int

    @property
    def branches(self) -> range:
        """The branch nodes, root first."""
        return range(1, 2**self.depth)

    @property
    def leaves(self) -> range:
        """The leaves, from left to right."""
        return range(2**self.depth, 2 ** (self.depth + 1))

    def path(self, leaf: int) -> list[tuple[int, bool]]:
        """Return the ancestors of a leaf, root first, each with whether the leaf lies on its left."""
        steps = []
        while leaf > 1:
            steps.append((leaf // 2, leaf % 2 == 0))
            leaf //= 2
        return steps[::-1]

    def left_ancestors(self, leaf: int) -> list[int]:
        """Return A_L(t): the ancestors on whose left side the leaf lies."""
        return [m for m, is_left in self.path(leaf) if is_left]

    def right_ancestors(self, leaf: int) -> list[int]:
        """Return A_R(t): the ancestors on whose right side the leaf lies."""
        return [m for m, is_left in self.path(leaf) if not is_left]

    def leaves_under(self, node: int) -> list[int]:
        """Return the positions in `leaves` (0 = leftmost) of the leaves below a node."""
        return [i for i, t in enumerate(self.leaves) if t >> (t.bit_length() - node.bit_length()) == node]

    def is_last_level(self, node: int) -> bool:
        """Whether the children of a branch node are leaves."""
        return node >= int(2 ** (self.depth - 1))


@dataclass(frozen=True, slots=True, eq=False)
class Placed:
    """A tree laid into a heap.

    Attributes
    ----------
    splits
        the split of each branch node that has one.
    labels
        the label at each leaf of the heap that a leaf of the tree sits at.
    position
        (n_samples,) the position in `Heap.leaves` that each sample reaches.
    flipped
        the splits whose sides are exchanged (see `turned`).
    """

    splits: Mapping[int, Split | HyperplaneSplit]
    labels: Mapping[int, int]
    position: NDArray[np.int64]
    flipped: frozenset[int] = frozenset()

    def turned(self, heap: Heap, sample: int) -> "Placed":
        """Return the same tree with the sides exchanged wherever `sample` went left, so that it ends rightmost.

        The splits that exchanged their sides are named in `flipped`, to be read with normals of the other sign.
        """
        splits: dict[int, Split | HyperplaneSplit] = {}
        labels: dict[int, int] = {}
        flipped: set[int] = set()
        moved = np.zeros(len(heap.leaves), dtype=np.int64)
        first, goal = heap.leaves[0], heap.leaves[int(self.position[sample])]
        stack = [(1, 1)]
        while stack:
            new, old = stack.pop()
            if new in heap.leaves:
                moved[old - first] = new - first
                if old in self.labels:
                    labels[new] = self.labels[old]
                continue
            is_flipped = goal >> (heap.depth + 1 - (2 * old).bit_length()) == 2 * old
            if old in self.splits:
                splits[new] = self.splits[old]
                flipped |= {new} if is_flipped else set()
            stack += [(2 * new + is_flipped, 2 * old), (2 * new + 1 - is_flipped, 2 * old + 1)]
        return Placed(splits, labels, moved[self.position], frozenset(flipped))


def place(tree: Node, heap: Heap, features: NDArray[np.float64]) -> Placed:
    """Return a tree laid into a heap, with where the rows of `features` (n_samples, n_features) end.

    Raises
    ------
    TreeError
        the tree is deeper than the heap.
    """
    splits: dict[int, Split | HyperplaneSplit] = {}
    labels: dict[int, int] = {}
    position = np.zeros(len(features), dtype=np.int64)
    stack: list[tuple[Node, int, NDArray[np.int64]]] = [(tree, 1, np.arange(len(features)))]
    while stack:
        node, m, rows = stack.pop()
        if m > heap.leaves[-1] or (m in heap.leaves and not isinstance(node, Leaf)):
            raise TreeError(
                f"a tree of depth {depth(tree)} does not fit into {heap.depth} levels of splits; give a shallower one"
            )
        if isinstance(node, Leaf):
            while m not in heap.leaves:
                m = 2 * m + 1
            labels[m] = node.label
            position[rows] = m - heap.leaves[0]
        else:
            splits[m] = node
            left = goes_left(node, features[rows])
            stack += [(node.left, 2 * m, rows[left]), (node.right, 2 * m + 1, rows[~left])]
    return Placed(splits, labels, position)


def to_tree(heap: Heap, splits: Mapping[int, Split | HyperplaneSplit], labels: Mapping[int, int]) -> Node:
    """Return the tree of a heap: the inverse of `place`. The children of the given splits are not read."""

    def build(m: int) -> Node:
        if m in heap.leaves:
            return Leaf(labels.get(m, 0))
        if m not in splits:
            return build(2 * m + 1)
        split = splits[m]
        if isinstance(split, Split):
            return Split(split.feature, split.threshold, build(2 * m), build(2 * m + 1))
        return HyperplaneSplit(split.features, split.coefficients, split.offset, build(2 * m), build(2 * m + 1))

    return build(1)
