"""Predictions of many rows: those of `octmip.trees.nodes.tree`, from the native core where it can.

The core goes down a tree of thresholds with blocks of rows. Certificates do without it: they count with
`octmip.trees.nodes.tree.leaf_index`, and a test holds the two together.
"""

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from octmip.errors import TreeError
from octmip.input.named_arrays import columns_of, numbers_in
from octmip.trees.nodes import tree as reference
from octmip.trees.nodes.tree import Leaf, Node, Split, depth, features_used, leaf_index, leaves, nodes

FEW_NODES, FEW_ROWS = 12, 1000
"""Of a tree and a table so small the lists of the tree take longer than the predictions."""


def predict(tree: Node, features: Any) -> NDArray[np.int64]:
    """Return the class index of every row of `features` (n_samples, n_features), shape (n_samples,).

    Columns of a frame are taken in their order, as a tree knows no names; what is masked is missing. Readings of
    float32 are compared as they are, without rounding a threshold. Fastest where rows lie one after the
    other (C order) and splits are of one feature.

    Raises
    ------
    TreeError
        a reading that a split asks for is missing (NaN), and it has no side for it; or its column is not there.
    DataError
        some are no numbers.

    Examples
    --------
    >>> predict(Split(0, 2.5, Leaf(0), Leaf(1), missing="right"), [[2.0], [float("nan")]])
    array([0, 1])
    """
    labels = np.array([leaf.label for leaf in leaves(tree)], dtype=np.int64)
    return labels[reached_leaves(tree, _array(features))]


def predict_values(tree: Node, features: Any) -> NDArray[np.float64]:
    """Return the number that a regression tree predicts for every row of `features`, shape (n_samples,).

    The products of a linear leaf are rounded to float64 and added from the first feature to the last.

    Raises
    ------
    TreeError
        a leaf predicts a class, not a number; a prediction is beyond float64; or a reading is missing.
    DataError
        some are no numbers.

    Examples
    --------
    >>> predict_values(Split(0, 2.5, ValueLeaf(10.0), ValueLeaf(20.0)), [[2.0], [3.0]])
    array([10., 20.])
    """
    features = _array(features)
    return reference.predict_values(tree, features, reached_leaves(tree, features))


def _array(features: Any) -> NDArray[Any]:
    """Return rows of numbers of any library as an array, NaN where one is missing."""
    if type(features) is np.ndarray and features.dtype.kind in "fiub":
        return features
    columns = columns_of(features)
    if columns is None:
        return numbers_in(features, "features")
    return np.column_stack([numbers_in(column, f"features, column {name!r}") for name, column in columns.items()])


def reached_leaves(tree: Node, features: NDArray[np.float64]) -> NDArray[np.int64]:
    """Return for every row of `features` (n_samples, n_features) the position of its leaf in `leaves(tree)`."""
    used = features_used(tree)
    if np.ndim(features) == 2 and used and max(used) >= np.shape(features)[1]:
        raise TreeError(
            f"features has {np.shape(features)[1]} columns, but the tree asks for feature {max(used)} "
            "(counted from 0); expected the columns of training in their order; give all of them"
        )
    is_plain = isinstance(features, np.ndarray) and features.ndim == 2 and features.dtype in (np.float64, np.float32)
    every = list(nodes(tree))
    is_small = len(every) < FEW_NODES and len(features) < FEW_ROWS
    if not is_plain or is_small or isinstance(tree, Leaf):
        return leaf_index(tree, features)
    if not (features.flags.c_contiguous and features.flags.aligned):  # as another process may send it
        return leaf_index(tree, features)
    if any(not isinstance(node, Leaf | Split) for node in every):
        return leaf_index(tree, features)
    from octmip.trees import _native  # the core is loaded by whoever needs it

    found = _native.reached_nodes(features, **_lists(every), depth=depth(tree))
    if found is None:  # refused there, in words
        return leaf_index(tree, features)
    position = np.cumsum([isinstance(node, Leaf) for node in every], dtype=np.int64) - 1
    return np.asarray(position[found])


def _lists(every: list[Node]) -> dict[str, list[Any]]:
    """Return features, thresholds, children and where missing readings go (True: right) of nodes in preorder.

    A leaf is a split whose children are the leaf itself.
    """
    sizes, children = [1] * len(every), [[k, k] for k in range(len(every))]
    for k in reversed(range(len(every))):  # one object may stand at several places: places come from the order alone
        if isinstance(every[k], Split):
            right = k + 1 + sizes[k + 1]
            children[k], sizes[k] = [k + 1, right], 1 + sizes[k + 1] + sizes[right]
    splits = [node if isinstance(node, Split) else None for node in every]
    features = [0 if split is None else split.feature for split in splits]
    thresholds = [math.nan if split is None else _threshold(split) for split in splits]
    missing = [
        False if split is None else None if split.missing is None else split.missing == "right" for split in splits
    ]
    return {"feature": features, "threshold": thresholds, "children": children, "missing": missing}


def _threshold(split: Split) -> float:
    """Return the largest reading that goes left: none does, or all do, where a split asks whether one is missing."""
    if split.threshold is not None:
        return split.threshold
    return math.inf if split.missing == "right" else math.nan
