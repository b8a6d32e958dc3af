"""Descent: trees of any kind made better by exact subtrees of two levels where sensors are read one after the other."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from octmip.sensing.sequential.native import Core
from octmip.trees.solution import Limits, Stop
from octmip.trees.tree import Leaf, Node, goes_left

BLOCK = 2
"""Levels of the subtrees that are solved exactly."""


def descend(core: Core, tree: Node, price: float, limits: Limits) -> Node:
    """Return the tree with its subtrees, from the bottom up, replaced by the best of two levels where that is better.

    Raises
    ------
    KeyboardInterrupt
        Ctrl-C while a subtree was searched for.
    """
    rows = np.arange(core.sequential.problem.n_samples)
    return _better(core, tree, price, limits, (rows, core.sequential.problem.depth, frozenset()))


def _better(
    core: Core,
    node: Node,
    price: float,
    limits: Limits,
    place: tuple[NDArray[np.int64], int, frozenset[str]],
) -> Node:
    rows, levels, read = place
    if levels == 0 or len(rows) == 0:
        return node
    if not isinstance(node, Leaf) and levels > BLOCK:
        left = goes_left(node, core.sequential.problem.features, rows)
        after = read | core.sequential.sensors_of(node.features)
        node = replace(
            node,
            left=_better(core, node.left, price, limits, (rows[left], levels - 1, after)),
            right=_better(core, node.right, price, limits, (rows[~left], levels - 1, after)),
        )
    room = weight_of(core, node, price, rows, read)
    found = core.search(price, room, limits, rows=rows, depth=min(levels, BLOCK), read=read)
    if found.stop == Stop.INTERRUPTED:
        raise KeyboardInterrupt
    return node if found.tree is None else found.tree


def weight_of(core: Core, node: Node, price: float, rows: NDArray[np.int64], read: frozenset[str]) -> float:
    """Return error + price * cost of a subtree for the samples of `rows`, after the sensors of `read`."""
    sequential = core.sequential
    if isinstance(node, Leaf):
        return float(core.paid[rows, node.label].sum())
    after = read | sequential.sensors_of(node.features)
    cost = sequential.path_cost(after) - sequential.path_cost(read)
    own = sequential.problem.leaf_penalty * len(node.features) + price * cost * float(sequential.counts[rows].sum())
    delay = (len(after) - len(read)) * float(sequential.delay_costs[rows].sum())
    left = goes_left(node, sequential.problem.features, rows)
    sides = ((node.left, rows[left]), (node.right, rows[~left]))
    return own + delay + sum(weight_of(core, side, price, part, after) for side, part in sides)
