"""The optimum by exhaustive enumeration: every affordable set of sensors, every cut of every feature, every depth.

Slow, short and exact: objectives are fractions, those of classes made whole by one common denominator, so nothing is
rounded and ties are ties. A set of samples is a bit mask. A cut of a feature that lacks readings is tried with the
missing ones left and right of it, and "is it missing?" is one cut more. Imports nothing of octmip but the problem and
the tree.
"""

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from fractions import Fraction
from functools import cache
from itertools import combinations, pairwise

import numpy as np

from octmip.trees.nodes.digits import midpoint
from octmip.trees.nodes.tree import Leaf, Node, Side, Split
from octmip.trees.question.problem import Problem

Cut = tuple[int, float | None, Side | None, int]  # feature, threshold, side of missing, mask of samples that go left
Best = tuple[int | Fraction, int, Node]  # cost, splits, tree


@dataclass(frozen=True, slots=True)
class Optimum:
    """The least objective, and the fewest splits, then the fewest sensors, among the trees that reach it."""

    objective: float
    n_splits: int
    n_sensors: int
    tree: Node


def optimum(problem: Problem) -> Optimum:
    """Return the optimum of an axis-aligned problem; effort grows as (samples x features)^depth x 2^sensors."""
    prices, denominator = whole_prices(problem)

    def leaf(samples: int) -> tuple[int, Leaf]:
        costs = zip(*(row for i, row in enumerate(prices[:-1]) if samples >> i & 1), strict=True)
        cost, label = min((sum(column), k) for k, column in enumerate(costs))
        return cost, Leaf(label)

    cost, n_splits, n_sensors, tree = least(problem, leaf, prices[-1][0])
    return Optimum(float(cost / denominator), n_splits, n_sensors, tree)


def least(
    problem: Problem, leaf: Callable[[int], tuple[int | Fraction, Leaf]], price: int | Fraction
) -> tuple[int | Fraction, int, int, Node]:
    """Return least cost, splits, sensors and tree, from the cost and the leaf of a mask and the price of a split."""
    found = []
    for n_sensors in range(len(problem.shape.sensors) + 1):
        for chosen in combinations(range(len(problem.shape.sensors)), n_sensors):
            if math.fsum(problem.shape.sensor_costs[list(chosen)]) <= problem.shape.sensor_limit:
                cost, n_splits, tree = _best_tree(problem, leaf, price, list(_cuts(problem, chosen)))
                found.append((cost, n_splits, n_sensors, tree))
    return min(found, key=lambda entry: entry[:3])


def whole_prices(problem: Problem) -> tuple[list[list[int]], int]:
    """Return prices[i][k] of predicting k for sample i, last row the penalty; all times the denominator returned."""
    costs = [[Fraction(float(c)) for c in problem.cost_table[row]] for row in problem.cost_rows]
    exact = [[Fraction(float(w)) * c for c in row] for w, row in zip(problem.samples.weights, costs, strict=True)]
    exact.append([Fraction(problem.shape.leaf_penalty)])
    denominator = math.lcm(*(c.denominator for row in exact for c in row))
    return [[int(c * denominator) for c in row] for row in exact], denominator


def _cuts(problem: Problem, sensors: tuple[int, ...]) -> Iterator[Cut]:
    for feature in range(problem.samples.n_features):
        if problem.shape.sensor_index[feature] in sensors and problem.shape.is_allowed((feature,)):
            column = problem.samples.features[:, feature]
            values = np.unique(column[~np.isnan(column)]).tolist()
            missing = sum(1 << int(i) for i in np.flatnonzero(np.isnan(column)))
            if missing:
                yield feature, None, "left", missing
            for low, high in pairwise(values):
                below = sum(1 << int(i) for i in np.flatnonzero(column <= low))
                yield feature, midpoint(low, high), "right" if missing else None, below
                if missing:
                    yield feature, midpoint(low, high), "left", below | missing


def _best_tree(
    problem: Problem, leaf: Callable[[int], tuple[int | Fraction, Leaf]], price: int | Fraction, cuts: list[Cut]
) -> Best:
    exact = [Fraction(weight) for weight in problem.samples.weights.tolist()]
    least = Fraction(problem.shape.least_leaf_weight)

    def weight(samples: int) -> Fraction:
        return sum((one for i, one in enumerate(exact) if samples >> i & 1), Fraction(0)) if least else least

    @cache
    def best(samples: int, depth: int) -> Best:
        cost, node = leaf(samples)
        found: Best = (cost, 0, node)
        for feature, threshold, missing, mask in cuts if depth else ():
            sides = samples & mask, samples & ~mask
            if min(side.bit_count() for side in sides) >= problem.shape.leaf_size and min(map(weight, sides)) >= least:
                left, right = (best(side, depth - 1) for side in sides)
                cost, n_splits = left[0] + right[0] + price, left[1] + right[1] + 1
                if (cost, n_splits) < found[:2]:
                    found = (cost, n_splits, Split(feature, threshold, left[2], right[2], missing=missing))
        return found

    return best((1 << problem.samples.n_samples) - 1, problem.shape.depth)
