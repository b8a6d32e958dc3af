"""Incumbents: the trees that a run starts from or finds, tidied, and what each costs."""

from dataclasses import replace

import numpy as np

from octmip.cart import greedy_tree
from octmip.errors import ProblemError
from octmip.problem import Problem
from octmip.tree import (
    HyperplaneSplit,
    Leaf,
    Node,
    Split,
    depth,
    leaf_index,
    leaves,
    simplify,
    without_empty_sides,
)


def starting_tree(problem: Problem, incumbent: Node | None, seed: int) -> Node:
    """Return the tree to start from: the incumbent, else CART's; one leaf where that is better.

    Raises:
        ProblemError: the incumbent is deeper than the problem allows.
    """
    tree = incumbent
    if tree is None:
        tree = greedy_tree(problem, seed=seed).tree
    assert tree is not None
    tree = tidy(problem, tree)
    if depth(tree) > problem.depth:
        raise ProblemError(f"the incumbent has depth {depth(tree)} but the problem allows {problem.depth}")
    leaf = Leaf(int(problem.class_costs().argmin()))
    return tree if problem.objective(tree) <= problem.objective(leaf) else leaf


def tidy(problem: Problem, tree: Node) -> Node:
    """Return the tree without empty sides, with the best label at every leaf, and equal leaves merged: never worse."""
    return simplify(relabelled(problem, without_empty_sides(tree, problem.features)))


def relabelled(problem: Problem, tree: Node) -> Node:
    """Return the tree with the label of least cost at every leaf that a sample reaches (the first of equals)."""
    index = leaf_index(tree, problem.features)
    labels = [leaf.label for leaf in leaves(tree)]
    for i in range(len(labels)):
        rows = np.flatnonzero(index == i)
        if len(rows):
            labels[i] = int(problem.class_costs(rows).argmin())
    remaining = iter(labels)

    def build(node: Node) -> Node:
        if isinstance(node, Split | HyperplaneSplit):
            left = build(node.left)
            return replace(node, left=left, right=build(node.right))
        return replace(node, label=next(remaining))

    return build(tree)
