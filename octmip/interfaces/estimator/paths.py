"""Nodes of a tree by number, as scikit-learn numbers them: in preorder, the root 0, left before right.

Five nodes, and the path of a sample that goes right, then left:

    0 split
    +- 1 leaf
    +- 2 split
       +- 3 leaf      path 0 2 3
       +- 4 leaf
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_matrix

from octmip.trees.nodes.tree import Leaf, Node, leaf_index, leaves, nodes


@dataclass(frozen=True, slots=True, eq=False)
class NodeTable:
    """The nodes of a tree as arrays, in preorder.

    Attributes
    ----------
    nodes
        each node.
    left, right
        (n_nodes,) number of the left and right child; -1 at a leaf.
    leaf_nodes
        (n_leaves,) number of each leaf, from the left.
    """

    nodes: tuple[Node, ...]
    left: NDArray[np.int64]
    right: NDArray[np.int64]
    leaf_nodes: NDArray[np.int64]

    @classmethod
    def of(cls, tree: Node) -> "NodeTable":
        """Return the table of a tree."""
        found = tuple(nodes(tree))
        left, right = np.full(len(found), -1), np.full(len(found), -1)
        for k, node in enumerate(found):
            if not isinstance(node, Leaf):
                left[k], right[k] = k + 1, k + 2 * len(leaves(node.left))
        return cls(found, left, right, np.flatnonzero(left < 0))


def leaf_nodes(tree: Node, features: NDArray[np.float64]) -> NDArray[np.int64]:
    """Return the number of the leaf that each sample (n_samples, n_features) reaches, shape (n_samples,)."""
    return NodeTable.of(tree).leaf_nodes[leaf_index(tree, features)]


def node_indicator(tree: Node, features: NDArray[np.float64]) -> csr_matrix:
    """Return which nodes each sample passes, a sparse matrix (n_samples, n_nodes) of 0 and 1."""
    table = NodeTable.of(tree)
    paths = _paths(table)
    reached = [paths[k] for k in leaf_index(tree, features).tolist()]
    ends = np.cumsum([0, *(len(path) for path in reached)])
    indices = np.concatenate(reached)
    return csr_matrix((np.ones(len(indices), dtype=np.int64), indices, ends), shape=(len(features), len(table.nodes)))


def _paths(table: NodeTable) -> list[NDArray[np.int64]]:
    """Return the nodes from the root to each leaf, leaves from the left."""
    parent = {int(child): k for side in (table.left, table.right) for k, child in enumerate(side) if child >= 0}
    found = []
    for leaf in table.leaf_nodes.tolist():
        path = [leaf]
        while path[-1] in parent:
            path.append(parent[path[-1]])
        found.append(np.array(path[::-1], dtype=np.int64))
    return found
