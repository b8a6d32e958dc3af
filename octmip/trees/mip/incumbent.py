"""Incumbents: the trees that a run starts from or finds, in canonical form and of at most so many splits."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from octmip.errors import ProblemError
from octmip.trees.methods.cart import greedy_tree
from octmip.trees.methods.native_call import relabelled
from octmip.trees.problem import Problem
from octmip.trees.problem_values import whole_of
from octmip.trees.tree import Leaf, Node, complexity, depth, goes_left, simplify, without_empty_sides


def starting_tree(problem: Problem, incumbent: Node | None, seed: int, max_splits: int | None = None) -> Node:
    """Return the tree to start from: the incumbent, else CART's, pruned to `max_splits`; one leaf where that is better.

    Raises
    ------
    ProblemError
        the incumbent is deeper than the problem allows, or `max_splits` is no whole number of 0 or more.
    """
    tree = incumbent
    if tree is None:
        tree = greedy_tree(problem, seed=seed).tree
    assert tree is not None
    tree = canonicalise(problem, tree, max_splits)
    if depth(tree) > problem.depth:
        raise ProblemError(
            f"the incumbent has depth {depth(tree)} but the problem allows {problem.depth}; give a tree that fits"
        )
    leaf = Leaf(int(problem.class_costs().argmin()))
    return tree if problem.objective(tree) <= problem.objective(leaf) else leaf


def canonicalise(problem: Problem, tree: Node, max_splits: int | None = None) -> Node:
    """Return the tree without empty sides, with the best label at every leaf, and equal leaves merged: never worse.

    Where it still has more splits than `max_splits` allows, it is pruned to them.
    """
    return pruned(problem, simplify(relabelled(problem, without_empty_sides(tree, problem.features))), max_splits)


def pruned(problem: Problem, tree: Node, max_splits: int | None) -> Node:
    """Return the best pruning of a tree with at most `max_splits` features in its splits; the tree itself if it fits.

    A pruning has a leaf of the best label in place of some splits. The best one for every number of features follows
    from those of the two sides, so one pass from the leaves to the root finds it.

    Raises
    ------
    ProblemError
        `max_splits` is no whole number of 0 or more.
    """
    if max_splits is None:
        return tree
    most = whole_of(max_splits, "max_splits", 0, None)
    if complexity(tree) <= most:
        return tree

    def by_number(node: Node, rows: NDArray[np.int64]) -> list[tuple[float, Node]]:
        """Return cost and pruning for 0, 1, 2, ... features at most; more than the last number changes nothing."""
        costs = problem.class_costs(rows)
        best: list[tuple[float, Node]] = [(float(costs.min()), Leaf(int(costs.argmin())))]
        if isinstance(node, Leaf):
            return best
        is_left = goes_left(node, problem.features, rows)
        lefts, rights = by_number(node.left, rows[is_left]), by_number(node.right, rows[~is_left])
        size = len(node.features)
        for number in range(1, min(most, complexity(node)) + 1):
            found = best[-1]
            for n_left in range(min(number - size, len(lefts) - 1) + 1):
                left, right = lefts[n_left], rights[min(number - size - n_left, len(rights) - 1)]
                cost = left[0] + right[0] + size * problem.leaf_penalty
                if cost < found[0]:
                    found = cost, replace(node, left=left[1], right=right[1])
            best.append(found)
        return best

    return by_number(tree, np.arange(problem.n_samples))[-1][1]
