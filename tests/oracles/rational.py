"""The least cost of any tree of a small problem, and what a tree costs, in fractions: nothing is rounded anywhere.

Axis-aligned splits of any number of samples, readings missing or not, by sums along the features; splits over two
features along any line, and lines of whole-numbered normals, by sets of samples as bit masks. Imports nothing of octmip
but the problem and the tree.
"""

import math
from collections.abc import Iterable, Iterator
from fractions import Fraction
from functools import cache
from itertools import combinations, product
from typing import Any

import numpy as np
from numpy.typing import NDArray

from octmip.trees.nodes.tree import Node, complexity, predict
from octmip.trees.question.problem import Problem
from tests.oracles.enumeration import whole_prices

Partings = dict[int, set[tuple[int, frozenset[int]]]]  # left samples: (features of the split, which)


def cost_of(problem: Problem, tree: Node) -> Fraction:
    """Return the objective of a tree; samples are routed in float64, as a tree at work routes them."""
    predicted = predict(tree, problem.samples.features).tolist()
    weights, costs = problem.samples.weights.tolist(), problem.cost_table.tolist()
    paid = (
        Fraction(w) * Fraction(costs[row][label])
        for w, row, label in zip(weights, problem.cost_rows.tolist(), predicted, strict=True)
    )
    return sum(paid, Fraction(problem.shape.leaf_penalty) * complexity(tree))


def least_cost(problem: Problem) -> Fraction:
    """Return the least objective over all trees, axis-aligned ones of `max_splits` splits at most.

    Effort grows as cuts^depth of axis-aligned trees, as partings^depth of others, times sets of sensors.
    """
    prices, denominator = whole_prices(problem)
    if problem.shape.split == "axis":
        best = min(_best_along(problem, features, prices) for features in _affordable(problem))
    else:
        parted = _partings(problem) if problem.shape.integer_normals is None else _whole_partings(problem)
        best = min(_best_cost(problem, _cheapest(parted, features), prices) for features in _affordable(problem))
    return Fraction(best, denominator)


def _affordable(problem: Problem) -> Iterator[frozenset[int]]:
    """Yield the features of every set of sensors that can be paid for and is no part of a larger one."""
    larger: list[set[int]] = []
    for size in range(len(problem.shape.sensors), -1, -1):
        for chosen in combinations(range(len(problem.shape.sensors)), size):
            is_new = not any(set(chosen) <= other for other in larger)
            if is_new and math.fsum(problem.shape.sensor_costs[list(chosen)]) <= problem.shape.sensor_limit:
                larger.append(set(chosen))
                yield frozenset(f for f, s in enumerate(problem.shape.sensor_index.tolist()) if s in chosen)


def _best_along(problem: Problem, features: frozenset[int], prices: list[list[int]]) -> int:
    """Return the least cost of axis-aligned trees over some features, in whole numbers of any size."""
    total = sum(max(row) for row in prices)
    table = np.array(prices[:-1], dtype=np.int64 if total < 2**62 else object)
    penalty, size, columns = prices[-1][0], problem.shape.leaf_size, _columns(problem, features)
    known: dict[tuple[bytes, int, int], int] = {}

    def best(rows: NDArray[np.bool_], depth: int, n_splits: int) -> int:
        key = rows.tobytes(), depth, n_splits
        if key not in known:
            known[key] = found(rows, depth, n_splits)
        return known[key]

    def found(rows: NDArray[np.bool_], depth: int, n_splits: int) -> int:
        least = int(table[rows].sum(axis=0).min())
        for order, ranks in columns if depth and n_splits else ():
            own = order[rows[order]]
            cuts = np.flatnonzero(np.diff(ranks[own])) + 1
            cuts = cuts[(cuts >= size) & (len(own) - cuts >= size)]
            if not len(cuts):
                continue
            if depth == 1 or n_splits == 1:
                sums = table[own].cumsum(axis=0)
                sides = sums[cuts - 1].min(axis=1) + (sums[-1] - sums[cuts - 1]).min(axis=1)
                least = min(least, int(sides.min()) + penalty)
                continue
            for cut in cuts.tolist():
                left, right = np.zeros_like(rows), np.zeros_like(rows)
                left[own[:cut]], right[own[cut:]] = True, True
                full = 2 ** (depth - 1) - 1  # splits of a whole tree on one side
                for of_left in range(max(0, n_splits - 1 - full), min(full, n_splits - 1) + 1):
                    ways = best(left, depth - 1, of_left) + best(right, depth - 1, n_splits - 1 - of_left)
                    least = min(least, ways + penalty)
        return least

    every = np.ones(problem.samples.n_samples, dtype=np.bool_)
    whole = 2**problem.shape.depth - 1
    most = whole if problem.shape.max_splits is None else min(problem.shape.max_splits, whole)
    return best(every, problem.shape.depth, most)


def _columns(problem: Problem, features: frozenset[int]) -> list[tuple[NDArray[np.int64], NDArray[np.int64]]]:
    """Return each feature's order of the samples and their ranks; missing readings are above, or below, all others."""
    found: list[tuple[NDArray[np.int64], NDArray[np.int64]]] = []
    for feature in sorted(features):
        if problem.shape.is_allowed((feature,)):
            column: NDArray[Any] = problem.samples.features[:, feature].astype(np.float64)
            is_missing = np.isnan(column)
            ranks = np.unique(np.where(is_missing, 0.0, column), return_inverse=True)[1].ravel() + 1
            for place in (len(column) + 1, 0) if is_missing.any() else (0,):
                placed = np.where(is_missing, place, ranks).astype(np.int64)
                found.append((np.argsort(placed, kind="stable"), placed))
    return found


def _cheapest(parted: Partings, features: frozenset[int]) -> dict[int, int]:
    """Return the fewest features by which each set of samples can be parted from the others."""
    sizes = {left: [size for size, used in ways if used <= features] for left, ways in parted.items()}
    return {left: min(some) for left, some in sizes.items() if some}


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
            if min(left.bit_count(), right.bit_count()) >= problem.shape.leaf_size:
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

    return best((1 << problem.samples.n_samples) - 1, problem.shape.depth)


def _partings(problem: Problem) -> Partings:
    """Return the partings by any line over two features, or a cut of one.

    Every way of parting distinct points by a line is that of the line through two of them, turned a little about a
    place on it, so the points on it come apart as a prefix and a suffix.
    """
    found: Partings = {}
    columns = [[Fraction(value) for value in column] for column in problem.samples.features.T.tolist()]
    everything = (1 << problem.samples.n_samples) - 1

    def add(left: int, features: tuple[int, ...]) -> None:
        for side in (left, everything ^ left):
            found.setdefault(side, set()).add((len(features), frozenset(features)))

    for f in range(problem.samples.n_features):
        if problem.shape.is_allowed((f,)):
            for value in set(columns[f]):
                add(_mask(x <= value for x in columns[f]), (f,))
    for f, g in combinations(range(problem.samples.n_features), 2):
        if problem.shape.is_allowed((f, g)):
            points = list(zip(columns[f], columns[g], strict=True))
            for a, b in combinations(sorted(set(points)), 2):
                normal = (b[1] - a[1], a[0] - b[0])
                turn = [normal[0] * (p[0] - a[0]) + normal[1] * (p[1] - a[1]) for p in points]
                for end in {p for p, t in zip(points, turn, strict=True) if t == 0}:
                    for is_upper in (False, True):
                        sides = zip(points, turn, strict=True)
                        add(_mask(t > 0 or (t == 0 and (p > end) == is_upper) for p, t in sides), (f, g))
    return found


def _mask(bits: Iterable[bool]) -> int:
    return sum(1 << i for i, bit in enumerate(bits) if bit)


def _whole_partings(problem: Problem) -> Partings:
    """Return the partings by lines whose normals are whole numbers within `integer_normals`."""
    assert problem.shape.integer_normals is not None
    columns = [[Fraction(value) for value in column] for column in problem.samples.features.T.tolist()]
    entries = range(-problem.shape.integer_normals, problem.shape.integer_normals + 1)
    found: Partings = {}
    for normal in product(entries, repeat=problem.samples.n_features):
        used = tuple(j for j, entry in enumerate(normal) if entry)
        if used and problem.shape.is_allowed(used):
            totals = [sum(c * x for c, x in zip(normal, row, strict=True)) for row in zip(*columns, strict=True)]
            for limit in set(totals):
                left = sum(1 << i for i, total in enumerate(totals) if total <= limit)
                found.setdefault(left, set()).add((len(used), frozenset(used)))
    return found
