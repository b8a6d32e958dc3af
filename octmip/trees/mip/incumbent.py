"""Incumbents: the trees that a run starts from or finds, in canonical form and of at most so many splits."""

from octmip.errors import ProblemError
from octmip.trees.methods.cart import greedy_tree
from octmip.trees.methods.native_call import relabelled
from octmip.trees.methods.pruning import pruned
from octmip.trees.nodes.reached import without_empty_sides
from octmip.trees.nodes.tree import Leaf, Node, depth, simplify
from octmip.trees.question.problem import Problem


def starting_tree(problem: Problem, incumbent: Node | None, seed: int) -> Node:
    """Return the tree to start from: the incumbent, else CART's; one leaf where that is better.

    Raises
    ------
    ProblemError
        the incumbent is deeper than the problem allows.
    """
    tree = incumbent
    if tree is None:
        tree = greedy_tree(problem, seed=seed).tree
    assert tree is not None
    tree = canonicalise(problem, tree)
    if depth(tree) > problem.shape.depth:
        raise ProblemError(
            f"the incumbent has depth {depth(tree)} but the problem allows {problem.shape.depth}; give a tree that fits"
        )
    leaf = Leaf(int(problem.class_costs().argmin()))
    return tree if problem.objective(tree) <= problem.objective(leaf) else leaf


def canonicalise(problem: Problem, tree: Node) -> Node:
    """Return the tree without empty sides, with the best label at every leaf, and equal leaves merged: never worse.

    Where it still has more splits than `Shape.max_splits` allows, it is pruned to them.
    """
    return pruned(
        problem,
        simplify(relabelled(problem, without_empty_sides(tree, problem.samples.features))),
        problem.shape.max_splits,
    )
