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
        tolerance: how far an integer optimum times `unit` may lie below the true optimum; 0 when nothing was rounded.
    """

    weights: NDArray[np.int64]
    costs: NDArray[np.int64]
    penalty: int
    unit: float
    tolerance: float


def rank_features(problem: Problem) -> Ranks:
    """Return the dense ranks of every feature of a problem."""
    ranks = np.empty((problem.n_features, problem.n_samples), dtype=np.uint32)
    values = []
    for feature in range(problem.n_features):
        distinct, inverse = np.unique(problem.features[:, feature], return_inverse=True)
        ranks[feature] = inverse
        values.append(distinct)
    return Ranks(ranks, tuple(values))


def integer_costs(problem: Problem) -> IntegerCosts:
    """Return the weights, costs and penalty of a problem as integers, rounded down where they are not whole.

    The smallest power of two makes dyadic numbers (0.5, 2.25) whole. Where there is none, or objectives of such
    integers could reach `CAPACITY`, the numbers are rounded down to the digits that fit `ROUNDED_CAPACITY`: every
    integer objective times `unit` is at most the true one, and none overflows.
    """
    weights, weight_unit = _whole_numbers(problem.weights, CAPACITY)
    prices = np.append(problem.costs.ravel(), problem.leaf_penalty / weight_unit)
    costs, cost_unit = _whole_numbers(prices, CAPACITY)
    penalty = int(costs[-1])
    matrix = costs[:-1].reshape(problem.costs.shape)
    if float(weights.sum()) * float(matrix.max()) + penalty * _most_features(problem) >= CAPACITY:
        weights, weight_unit, matrix, cost_unit, penalty = _rounded_numbers(problem)
    unit = weight_unit * cost_unit
    loss = _rounding_loss(problem, weights * weight_unit, matrix * cost_unit, penalty * unit)
    return IntegerCosts(weights, matrix, penalty, unit, loss)


def _rounded_numbers(problem: Problem) -> tuple[NDArray[np.int64], float, NDArray[np.int64], float, int]:
    """Return weights and their unit, costs and theirs, and the penalty, rounded down into `ROUNDED_CAPACITY`.

    Costs keep their digits where they have few (0/1), weights take what room is left, and costs what they leave.
    """
    ceiling, penalty = _ceiling(problem), _effective_penalty(problem)
    room = ROUNDED_CAPACITY * ceiling / (ceiling + penalty * _most_features(problem))
    # A cost loses 2^-digits of itself, the n weights together n 2^-(digits left): least when the two are equal.
    digits = (math.log2(ROUNDED_CAPACITY) - math.log2(problem.n_samples)) / 2
    costs, cost_unit = _whole_numbers(problem.costs.ravel(), 2.0**digits)
    largest = max(float(costs.max()), 1.0)
    weights, weight_unit = _whole_numbers(problem.weights, room / largest)
    spare = 2.0 ** max(0, math.floor(math.log2(room / (max(float(weights.sum()), 1.0) * largest))))
    cost_unit /= spare
    matrix = np.floor(problem.costs / cost_unit).astype(np.int64)
    return weights, weight_unit, matrix, cost_unit, math.floor(penalty / (weight_unit * cost_unit))


def _ceiling(problem: Problem) -> float:
    """Return what no tree's errors can exceed."""
    return max(float(problem.weights.sum()) * float(problem.costs.max()), 1e-300)


def _effective_penalty(problem: Problem) -> float:
    """Return the penalty, at most twice the ceiling: above it no split ever pays, and the optimum is the same leaf."""
    return min(problem.leaf_penalty, 2 * _ceiling(problem))


def _most_features(problem: Problem) -> float:
    """Return the largest complexity of a tree of the problem."""
    return min(2.0**problem.depth - 1, problem.n_samples) * problem.max_split_size


def _whole_numbers(numbers: NDArray[np.float64], capacity: float) -> tuple[NDArray[np.int64], float]:
    """Return ``floor(numbers * scale)`` of a sum of at most `capacity`, and ``1 / scale``.

    The scale is 1 or the least power of two that makes the numbers whole; where there is none, the greatest that fits.
    """
    total = max(float(numbers.sum()), 1e-300)
    if (numbers == np.floor(numbers)).all() and total <= capacity:
        return numbers.astype(np.int64), 1.0
    most = math.floor(math.log2(capacity / total))
    for exponent in range(1, most + 1):
        scaled = numbers * 2.0**exponent
        if (scaled == np.floor(scaled)).all():
            return scaled.astype(np.int64), 2.0**-exponent
    return np.floor(numbers * 2.0**most).astype(np.int64), 2.0**-most


def _rounding_loss(problem: Problem, weights: FloatArray, costs: FloatArray, penalty: float) -> float:
    """Return the most by which an optimum counted with the rounded numbers can lie below the true one."""
    exact = np.array_equal(weights, problem.weights) and np.array_equal(costs, problem.costs)
    if exact and penalty == problem.leaf_penalty:
        return 0.0
    true = problem.weights[:, None] * problem.costs[problem.codes]
    held = weights[:, None] * costs[problem.codes]
    penalty_loss = (_effective_penalty(problem) - penalty) * _most_features(problem)
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
    """Return what hyperplane splits need beside the ranks: values (n_features, n_samples) and the limits of a split."""
    if problem.max_split_size == 1:
        return None
    groups = problem.allowed_splits
    members = None if groups is None else [[int(feature) for feature in group] for group in groups]
    values = np.ascontiguousarray(problem.features.T)
    return values, problem.max_split_size, members, problem.integer_normals


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
