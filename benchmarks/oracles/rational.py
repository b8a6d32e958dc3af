"""The least cost of any tree of a small problem, and what a tree costs, in fractions: nothing is rounded anywhere.

Axis-aligned splits, splits over two features along any line, and lines of whole-numbered normals. A set of samples is a
bit mask. Imports nothing of octmip but the problem and the tree.
"""

import math
from collections.abc import Iterator
from fractions import Fraction
from functools import cache
from itertools import combinations, product

from benchmarks.oracles.two_feature import partings
from octmip.problem import Problem
from octmip.tree import Node, complexity, predict

Partings = dict[int, set[tuple[int, frozenset[int]]]]  # left samples: (features of the split, which)


def cost_of(problem: Problem, tree: Node) -> Fraction:
    """Return the objective of a tree; samples are routed in float64, as a tree at work routes them."""
    predicted = predict(tree, problem.features).tolist()
    weights, costs = problem.weights.tolist(), problem.costs.tolist()
    paid = (
        Fraction(w) * Fraction(costs[code][label])
        for w, code, label in zip(weights, problem.codes.tolist(), predicted, strict=True)
    )
    return sum(paid, Fraction(problem.leaf_penalty) * complexity(tree))


def least_cost(problem: Problem) -> Fraction:
    """Return the least objective over all trees; effort grows as partings^depth x 2^sensors."""
    parted = partings(problem) if problem.integer_normals is None else _whole_partings(problem)
    prices, denominator = _whole_prices(problem)
    best = min(_best_cost(problem, _cheapest(parted, features), prices) for features in _affordable(problem))
    return Fraction(best, denominator)


def _affordable(problem: Problem) -> Iterator[frozenset[int]]:
    """Yield the features of every set of sensors that can be paid for."""
    for size in range(len(problem.sensors) + 1):
        for chosen in combinations(range(len(problem.sensors)), size):
            if math.fsum(problem.sensor_costs[list(chosen)]) <= problem.sensor_limit:
                yield frozenset(f for f, s in enumerate(problem.sensor_index.tolist()) if s in chosen)


def _cheapest(parted: Partings, features: frozenset[int]) -> dict[int, int]:
    """Return the fewest features by which each set of samples can be parted from the others."""
    sizes = {left: [size for size, used in ways if used <= features] for left, ways in parted.items()}
    return {left: min(some) for left, some in sizes.items() if some}


def _whole_prices(problem: Problem) -> tuple[list[list[int]], int]:
    """Return prices[i][k] of predicting k for sample i, last row the penalty; all times the denominator returned."""
    costs = [[Fraction(c) for c in row] for row in problem.costs.tolist()]
    exact = [
        [Fraction(w) * c for c in costs[code]]
        for w, code in zip(problem.weights.tolist(), problem.codes.tolist(), strict=True)
    ]
    exact.append([Fraction(problem.leaf_penalty)])
    denominator = math.lcm(*(c.denominator for row in exact for c in row))
    return [[int(c * denominator) for c in row] for row in exact], denominator


def _best_cost(problem: Problem, sizes: dict[int, int], prices: list[list[int]]) -> int:
    penalty = prices[-1][0]

    @cache
    def best(samples: int, depth: int) -> int:
        rows = [row for i, row in enumerate(prices[:-1]) if samples >> i & 1]
        found: int = min(sum(column) for column in zip(*rows, strict=True))
        if depth == 0:
            return found
        for left, size in sides(samples).items():
            right = samples ^ left
            if min(left.bit_count(), right.bit_count()) >= problem.leaf_size:
                found = min(found, best(left, depth - 1) + best(right, depth - 1) + penalty * size)
        return found

    @cache
    def sides(samples: int) -> dict[int, int]:
        parts: dict[int, int] = {}
        for left, size in sizes.items():
            part = samples & left
            if part and part != samples:
                parts[part] = min(size, parts.get(part, size))
        return parts

    return best((1 << problem.n_samples) - 1, problem.depth)


def _whole_partings(problem: Problem) -> Partings:
    """Return the partings by lines whose normals are whole numbers within `integer_normals`."""
    assert problem.integer_normals is not None
    columns = [[Fraction(value) for value in column] for column in problem.features.T.tolist()]
    entries = range(-problem.integer_normals, problem.integer_normals + 1)
    found: Partings = {}
    for normal in product(entries, repeat=problem.n_features):
        used = tuple(j for j, entry in enumerate(normal) if entry)
        if used and problem.is_allowed(used):
            totals = [sum(c * x for c, x in zip(normal, row, strict=True)) for row in zip(*columns, strict=True)]
            for limit in set(totals):
                left = sum(1 << i for i, total in enumerate(totals) if total <= limit)
                found.setdefault(left, set()).add((len(used), frozenset(used)))
    return found
