"""A tree put in the order that a problem asks for: its splits stay, thresholds move where no sample lies, leaves pool.

Without a cost a threshold moves within the gap between the samples on its two sides: leaves of other branches then
lie beside it no more. What is still out of order gets common predictions.

Of classes two leaves out of order get the best common class, and keep it together when another joins them. Of numbers
the best predictions for these leaves are known: of all sets of leaves that hold every leaf below one of theirs, the one
whose best common number is least has it; and so on with the leaves that are left.

Source: Barlow, Bartholomew, Bremner & Brunk (1972), Statistical Inference under Order Restrictions: pooling of adjacent
violators, and the minimum lower sets of section 2.3, there for means.
"""

import math
from collections.abc import Iterator
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from octmip.trees.nodes.order import disorder, n_disorders, ordered_pairs
from octmip.trees.nodes.tree import (
    HyperplaneSplit,
    Leaf,
    Node,
    Split,
    ValueLeaf,
    goes_left,
    leaf_index,
    leaves,
    simplify,
    splits,
)
from octmip.trees.question.problem import Problem
from octmip.trees.question.shape import with_leaves

MOST_SPLITS = 15
"""Of trees with more splits no threshold moves: each place is tried beside all pairs of leaves."""
MOST_LEAVES = 10
"""Of trees with more leaves only neighbours pool: lower sets are as many as subsets of the leaves."""
MOST_WORK = 2**20
"""Samples times lower sets, where the best number of each takes a sort."""


def ordered(problem: Problem, tree: Node) -> Node:
    """Return a tree whose leaves keep the problem's order; the tree itself if it does."""
    if problem.shape.monotone is None or disorder(tree, problem.shape.directions) is None:
        return tree
    tree = _aligned(problem, tree)
    if disorder(tree, problem.shape.directions) is None:
        return tree
    found = [_pooled(problem, tree)]
    if problem.loss.predicts == "number" and (best := _lower_sets(problem, tree)) is not None:
        found.append(best)
    return simplify(min(found, key=problem.objective))


def _aligned(problem: Problem, tree: Node) -> Node:
    """Return the tree with thresholds moved between samples, where fewer leaves are then out of order."""
    if len(splits(tree)) > MOST_SPLITS or problem.samples.takes_missing:
        return tree
    count = n_disorders(tree, problem.shape.directions)
    gaps = list(_gaps(problem, tree, np.arange(problem.samples.n_samples), ()))
    known = {(feature, place) for _, feature, low, high in gaps for place in (low, math.nextafter(high, low))}
    for split in splits(tree):
        assert isinstance(split, Split)  # hyperplanes have no order
        assert split.threshold is not None  # nor have missing readings
        known.add((split.feature, split.threshold))
    for path, feature, low, high in gaps:
        for place in sorted(place for other, place in known if other == feature and low <= place < high):
            moved = _moved(tree, path, place)
            if count and (fewer := n_disorders(moved, problem.shape.directions)) < count:
                tree, count = moved, fewer
    return tree


def _gaps(
    problem: Problem, tree: Node, rows: NDArray[np.int64], path: tuple[bool, ...]
) -> Iterator[tuple[tuple[bool, ...], int, float, float]]:
    """Yield of each split its path (right is True), its feature, the last value on the left and the first beyond."""
    if isinstance(tree, Leaf):
        return
    assert not isinstance(tree, HyperplaneSplit)
    is_left = goes_left(tree, problem.samples.features, rows)
    values = problem.samples.features[rows, tree.feature].astype(np.float64)
    if is_left.any() and not is_left.all():
        yield path, tree.feature, float(values[is_left].max()), float(values[~is_left].min())
    yield from _gaps(problem, tree.left, rows[is_left], (*path, False))
    yield from _gaps(problem, tree.right, rows[~is_left], (*path, True))


def _moved(tree: Node, path: tuple[bool, ...], place: float) -> Node:
    assert not isinstance(tree, Leaf | HyperplaneSplit)
    if not path:
        return replace(tree, threshold=place)
    if path[0]:
        return replace(tree, right=_moved(tree.right, path[1:], place))
    return replace(tree, left=_moved(tree.left, path[1:], place))


def _pooled(problem: Problem, tree: Node) -> Node:
    """Return the tree where leaves out of order have one prediction, the nearest two first."""
    reached = leaf_index(tree, problem.samples.features)
    predicted = leaves(tree)
    group = np.arange(len(predicted))
    while (found := disorder(tree, problem.shape.directions)) is not None:
        group[group == group[found[1]]] = group[found[0]]
        together = group == group[found[0]]
        pooled, _ = problem.leaf_and_cost(np.flatnonzero(together[reached]))
        predicted = [pooled if joins else leaf for leaf, joins in zip(predicted, together.tolist(), strict=True)]
        tree = with_leaves(tree, iter(predicted))
    return tree


def _lower_sets(problem: Problem, tree: Node) -> Node | None:
    """Return the tree with the best numbers in order; None where its leaves are too many, or rounding is in the way."""
    samples = problem.samples
    n_leaves = len(leaves(tree))
    is_mean = problem.number_loss.slopes is None
    if n_leaves > MOST_LEAVES or (not is_mean and samples.n_samples << n_leaves > MOST_WORK):
        return None
    below = [1 << leaf for leaf in range(n_leaves)]
    for i, j, _, way in ordered_pairs(tree, problem.shape.directions):
        low, high = (i, j) if way > 0 else (j, i)
        below[high] |= 1 << low
    reached = leaf_index(tree, samples.features)
    rows_of = [np.flatnonzero(reached == leaf) for leaf in range(n_leaves)]
    sums = np.array([[samples.weights[rows].sum(), samples.weights[rows] @ samples.codes[rows]] for rows in rows_of])

    def rows(mask: int) -> NDArray[np.int64]:
        return np.concatenate([rows_of[leaf] for leaf in range(n_leaves) if mask >> leaf & 1])

    def value(mask: int) -> float:
        if not is_mean:
            best = problem.best_leaf(rows(mask))
            assert isinstance(best, ValueLeaf)
            return best.value
        weight, total = sums[[leaf for leaf in range(n_leaves) if mask >> leaf & 1]].sum(axis=0)
        return float(total / weight) if weight > 0 else 0.0

    every = range(1, 1 << n_leaves)
    closed = [mask for mask in every if all(b & ~mask == 0 for leaf, b in enumerate(below) if mask >> leaf & 1)]
    done, predicted = 0, leaves(tree)
    while done != (1 << n_leaves) - 1:
        left = {mask & ~done for mask in closed if mask & done == done and mask != done}
        chosen = min(left, key=lambda mask: (value(mask), -mask.bit_count()))
        leaf = problem.best_leaf(rows(chosen))
        predicted = [leaf if chosen >> k & 1 else old for k, old in enumerate(predicted)]
        done |= chosen
    found = with_leaves(tree, iter(predicted))
    return found if disorder(found, problem.shape.directions) is None else None
