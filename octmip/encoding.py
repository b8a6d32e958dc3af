"""The way to the native core and back: a Problem as ranks and integers, a table of nodes as a tree.

Ranks, not values, enter the core. Feature values of float64 become dense ranks 0, 1, ...; a cut "rank <= k" comes back
as the guarded midpoint of the k-th and (k+1)-th distinct value, so no float64 value is ever compared after rounding:

    values       0.5  0.5  1.5  4.0  4.0
    ranks          0    0    1    2    2
    cut 1 means   rank <= 1, threshold midpoint(1.5, 4.0) = 2.75

Costs become integers. Integer weights and costs enter as they are; others are multiplied by a power of two and rounded
DOWN, so that a bound proven on the integers holds for the real costs too; the loss is `IntegerCosts.tolerance`.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from octmip import _native
from octmip.problem import Problem
from octmip.tree import HyperplaneSplit, Leaf, Node, Split, midpoint

FloatArray = NDArray[np.floating]
CAPACITY = 2.0**52  # exact integer objectives stay below it, so float64 holds every one of them exactly
ROUNDED_CAPACITY = 2.0**60  # rounded ones need more digits than that, and sums of two of them still fit 63 bits

# One node of the native core's table, preorder, root first:
# (kind 0 leaf | 1 split | 2 hyperplane, feature, cut, left, right, label, [(feature, coefficient)], offset)
NodeRow = tuple[int, int, int, int, int, int, list[tuple[int, float]], float]


@dataclass(frozen=True, slots=True, eq=False)
class Ranks:
    """Dense ranks of each feature, and the distinct values behind them.

    Attributes:
        ranks: (n_features, n_samples) uint32, C-contiguous.
        values: for each feature its distinct values, ascending: ``features[i, j] == values[j][ranks[j, i]]``.
    """

    ranks: NDArray[np.uint32]
    values: tuple[NDArray[np.float64], ...]


@dataclass(frozen=True, slots=True, eq=False)
class IntegerCosts:
    """Weights, costs and penalty as integers.

    Attributes:
        weights: (n_samples,) int64.
        costs: (n_classes, n_classes) int64.
        penalty: of one feature in one split.
        unit: what an integer objective is multiplied by to give the problem's.
        weight_unit: the part of `unit` that scales the weights; both are powers of two.
        tolerance: how far an integer optimum times `unit` may lie below the true optimum; 0 when nothing was rounded.
    """

    weights: NDArray[np.int64]
    costs: NDArray[np.int64]
    penalty: int
    unit: float
    weight_unit: float
    tolerance: float


def rank_features(problem: Problem) -> Ranks:
    """Return the dense ranks of every feature of a problem."""
    ranks, values = _native.dense_ranks(problem.features)
    return Ranks(ranks, tuple(values))


def integer_costs(problem: Problem) -> IntegerCosts:
    """Return the weights, costs and penalty of a problem as integers, rounded down where they are not whole.

    The smallest powers of two that make dyadic numbers (0.5, 2.25) whole; where none below `CAPACITY` does, numbers are
    scaled to `ROUNDED_CAPACITY` in sum and rounded down, so every integer objective times `unit` is at most the true
    one. A penalty above every other cost is cut to just above: no tree with a split is optimal either way.
    """
    weight_exponent, cost_exponent = _exponents(problem)
    weights = np.floor(np.ldexp(problem.weights, weight_exponent)).astype(np.int64)
    costs = np.floor(np.ldexp(problem.costs, cost_exponent)).astype(np.int64)
    weight_unit, unit = 2.0**-weight_exponent, 2.0 ** -(weight_exponent + cost_exponent)
    above_all = int(weights.sum()) * max(int(costs.max()), 1) + 1
    penalty = math.floor(min(problem.leaf_penalty / unit, above_all))
    paid = problem.leaf_penalty if penalty == above_all else penalty * unit
    loss = _rounding_loss(problem, weights * weight_unit, costs * (unit / weight_unit), paid, above_all < CAPACITY)
    return IntegerCosts(weights, costs, penalty, unit, weight_unit, loss)


def _exponents(problem: Problem) -> tuple[int, int]:
    """Return the powers of two that weights and costs are multiplied by."""
    largest = float(problem.weights.sum()) * (float(problem.costs.max()) or 1.0)
    room = math.floor(math.log2(CAPACITY / largest))
    weights, costs = _whole_exponent(problem.weights, room), _whole_exponent(problem.costs, room)
    if weights is not None and costs is not None and weights + costs <= room:
        penalty = _whole_exponent(np.array([problem.leaf_penalty]), room)
        if penalty is not None:
            return weights, max(costs, penalty - weights)
    room = math.floor(math.log2(ROUNDED_CAPACITY / largest))
    if weights is not None and weights <= room // 2:
        return weights, room - weights
    if costs is not None and costs <= room // 2:
        return room - costs, costs
    # A weight loses up to 2^-a on each of n samples, a cost up to 2^-b on the sum of the weights: best when equal.
    balance = math.log2(problem.n_samples * float(problem.costs.max()) / float(problem.weights.sum()))
    half = math.floor((room + balance) / 2)
    return half, room - half


def _whole_exponent(numbers: NDArray[np.float64], most: int) -> int | None:
    """Return the least power of two, `most` at most, that makes all of them whole."""
    for exponent in range(most + 1):
        scaled = np.ldexp(numbers, exponent)
        if (scaled == np.floor(scaled)).all():
            return exponent
    return None


def _rounding_loss(
    problem: Problem, weights: FloatArray, costs: FloatArray, penalty: float, sums_are_exact: bool
) -> float:
    """Return the most by which an objective counted with the rounded numbers can lie below the true one."""
    exact = np.array_equal(weights, problem.weights) and np.array_equal(costs, problem.costs)
    if exact and penalty == problem.leaf_penalty and sums_are_exact:
        return 0.0
    true = problem.weights[:, None] * problem.costs[problem.codes]
    held = weights[:, None] * costs[problem.codes]
    most_features = min(2.0**problem.depth - 1, problem.n_samples) * problem.max_split_size
    penalty_loss = (problem.leaf_penalty - penalty) * most_features
    rounding_of_sums = 1e-15 * float(true.max(axis=1).sum())
    return float((true - held).max(axis=1).sum()) + penalty_loss + rounding_of_sums


def native_problem(problem: Problem, ranks: Ranks, costs: IntegerCosts) -> _native.Problem:
    """Return the problem as the native core holds it."""
    allowed = [problem.is_allowed((feature,)) for feature in range(problem.n_features)]
    return _native.Problem(
        ranks.ranks,
        [len(values) for values in ranks.values],
        problem.codes.astype(np.uint32),
        costs.weights,
        costs.costs,
        costs.penalty,
        problem.depth,
        problem.leaf_size,
        problem.sensor_index.tolist(),
        problem.sensor_costs.tolist(),
        problem.sensor_limit,
        allowed,
        _planes(problem),
    )


def _planes(
    problem: Problem,
) -> tuple[NDArray[np.float64], int, list[list[int]] | None, int | None] | None:
    """Return what hyperplane splits need beside the ranks: values (n_samples, n_features) and the limits of a split."""
    if problem.max_split_size == 1:
        return None
    groups = problem.allowed_splits
    members = None if groups is None else [[int(feature) for feature in group] for group in groups]
    return np.ascontiguousarray(problem.features), problem.max_split_size, members, problem.integer_normals


def tree_from_rows(rows: Sequence[NodeRow], ranks: Ranks) -> Node:
    """Return the tree that a native node table stands for, thresholds at guarded midpoints."""

    def build(index: int) -> Node:
        kind, feature, cut, left, right, label, terms, offset = rows[index]
        if kind == 0:
            return Leaf(label)
        if kind == 1:
            values = ranks.values[feature]
            return Split(feature, midpoint(float(values[cut]), float(values[cut + 1])), build(left), build(right))
        ordered = sorted(terms)
        features, coefficients = tuple(f for f, _ in ordered), tuple(c for _, c in ordered)
        return HyperplaneSplit(features, coefficients, offset, build(left), build(right))

    return build(0)


def rows_from_tree(tree: Node, ranks: Ranks) -> list[NodeRow]:
    """Return the native node table of a tree; a threshold outside the data's range becomes the nearest cut."""
    rows: list[NodeRow] = []

    def add(node: Node) -> int:
        index = len(rows)
        rows.append((0, 0, 0, 0, 0, 0, [], 0.0))
        if isinstance(node, Leaf):
            rows[index] = (0, 0, 0, 0, 0, node.label, [], 0.0)
            return index
        left, right = add(node.left), add(node.right)
        if isinstance(node, Split):
            # Trees whose sides all hold samples (see `tree.without_empty_sides`) have 0 <= cut < number of values - 1.
            cut = int(np.searchsorted(ranks.values[node.feature], node.threshold, side="right")) - 1
            rows[index] = (1, node.feature, cut, left, right, 0, [], 0.0)
        else:
            terms = list(zip(node.features, node.coefficients, strict=True))
            rows[index] = (2, 0, 0, left, right, 0, terms, node.offset)
        return index

    add(tree)
    return rows
