"""A tree changed by the rows that reach its nodes: sides without rows taken out, thresholds put midway between rows."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from octmip.trees.nodes.digits import midpoint
from octmip.trees.nodes.tree import HyperplaneSplit, Leaf, Node, Split, goes_left


def without_empty_sides(tree: Node, features: NDArray[np.float64]) -> Node:
    """Return the tree without splits that send all the rows of `features` (n_samples, n_features) to one side."""

    def taken(node: Node, rows: NDArray[np.int64]) -> Node:  # row numbers: rows themselves would be the table again
        if isinstance(node, Leaf):
            return node
        left = goes_left(node, features, rows)
        if left.all():
            return taken(node.left, rows)
        if not left.any():
            return taken(node.right, rows)
        return replace(node, left=taken(node.left, rows[left]), right=taken(node.right, rows[~left]))

    return taken(tree, np.arange(len(features)))


def centred(tree: Node, features: NDArray[np.float64]) -> Node:
    """Return the tree with every threshold midway between the rows of its own node: the widest margin it can have.

    Every split must part the rows of `features` (n_samples, n_features); hyperplanes stay as they are.
    """

    def moved(node: Node, rows: NDArray[np.int64]) -> Node:
        if isinstance(node, Leaf):
            return node
        goes = goes_left(node, features, rows)
        left, right = moved(node.left, rows[goes]), moved(node.right, rows[~goes])
        if isinstance(node, HyperplaneSplit):
            return replace(node, left=left, right=right)
        values = features[rows, node.feature]
        below, above = (side[~np.isnan(side)] for side in (values[goes], values[~goes]))
        if not len(below) or not len(above):  # what parts these rows is that some lack the reading
            return Split(node.feature, None, left, right, missing="left" if len(above) else "right")
        return replace(node, threshold=midpoint(float(below.max()), float(above.min())), left=left, right=right)

    return moved(tree, np.arange(len(features)))
