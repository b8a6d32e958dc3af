"""The best regression tree by exhaustive enumeration, and random problems for it.

Every affordable set of sensors, every cut, every depth; errors are rational numbers, so nothing is rounded. Imports
nothing of octmip but the problem and the name of its loss.
"""

import math
from collections.abc import Iterator
from fractions import Fraction
from functools import cache
from itertools import combinations

import numpy as np

from octmip.trees.losses import number_loss
from octmip.trees.problem import Problem

Cut = int  # mask of the samples that go left


def least_objective(problem: Problem) -> Fraction:
    """Return the least objective of an axis-aligned tree with the best constant in each leaf."""
    found = []
    for n_sensors in range(len(problem.sensors) + 1):
        for chosen in combinations(range(len(problem.sensors)), n_sensors):
            if math.fsum(problem.sensor_costs[list(chosen)]) <= problem.sensor_limit:
                found.append(_least(problem, list(_cuts(problem, chosen))))
    return min(found)


def slopes_of(problem: Problem) -> tuple[Fraction, Fraction]:
    """Return what a target costs above its prediction and below it, for each unit of distance."""
    level = getattr(problem.loss, "level", None)
    if level is None:
        return Fraction(1), Fraction(1)
    above = Fraction(level).limit_denominator(1000)
    return above, 1 - above


def _cuts(problem: Problem, sensors: tuple[int, ...]) -> Iterator[Cut]:
    for feature in range(problem.n_features):
        if problem.sensor_index[feature] in sensors:
            column = problem.features[:, feature]
            for low in np.unique(column)[:-1].tolist():
                yield sum(1 << int(i) for i in np.flatnonzero(column <= low))


def _least(problem: Problem, cuts: list[Cut]) -> Fraction:
    targets = [Fraction(y) for y in problem.targets.tolist()]
    weights = [Fraction(w) for w in problem.weights.tolist()]

    @cache
    def leaf(samples: int) -> Fraction:
        rows = [i for i in range(len(targets)) if samples >> i & 1]
        total = sum((weights[i] for i in rows), Fraction(0))
        if problem.loss.name == "squared":
            first = sum((weights[i] * targets[i] for i in rows), Fraction(0))
            square = sum((weights[i] * targets[i] ** 2 for i in rows), Fraction(0))
            return square - first * first / total if total else square
        up, down = slopes_of(problem)
        misses = [[(targets[i] - targets[j]) * weights[i] for i in rows] for j in rows]
        return min((sum((max(up * m, -down * m) for m in of), Fraction(0)) for of in misses), default=Fraction(0))

    @cache
    def best(samples: int, depth: int) -> Fraction:
        found = leaf(samples)
        for mask in cuts if depth else ():
            sides = samples & mask, samples & ~mask
            if min(side.bit_count() for side in sides) >= problem.leaf_size:
                cost = sum((best(side, depth - 1) for side in sides), Fraction(problem.leaf_penalty))
                found = min(found, cost)
        return found

    return best((1 << problem.n_samples) - 1, problem.depth)


def random_problem(
    rng: np.random.Generator, loss: str, *, max_samples: int = 10, max_features: int = 3, max_depth: int = 3
) -> Problem:
    """Return a random problem: ties, weights (0 too), leaf sizes, penalties, budgets, targets of many kinds."""
    n, p = int(rng.integers(1, max_samples + 1)), int(rng.integers(1, max_features + 1))
    features = [
        rng.integers(0, rng.integers(2, 8), (n, p)).astype(float),
        rng.normal(size=(n, p)),
        np.round(rng.normal(size=(n, p)), 1),
    ][rng.integers(3)]
    targets = [
        rng.integers(0, 5, n) * 20.0,
        rng.normal(size=n),
        np.round(rng.normal(size=n), 1),
        rng.integers(-3, 4, n) / 8,
        1e6 + rng.normal(size=n),
        np.full(n, 0.1),
    ][rng.choice(6, p=[0.3, 0.25, 0.2, 0.15, 0.08, 0.02])]
    options: dict[str, object] = {"depth": int(rng.integers(1, max_depth + 1)), "loss": number_loss(loss)}
    if rng.random() < 0.4:
        weights = [rng.random(n), rng.integers(0, 4, n).astype(float), rng.integers(1, 3, n) / 4][rng.integers(3)]
        weights[0] = max(weights[0], 0.25)
        options["weights"] = weights
    if rng.random() < 0.4:
        options["leaf_size"] = min(n, int(rng.integers(1, max(2, n // 2) + 1)))
    if rng.random() < 0.3:
        options["leaf_penalty"] = float(rng.choice([0.5, 1.0, 20.0, 0.3, rng.random()]))
    if rng.random() < 0.4:
        n_sensors = int(rng.integers(1, p + 1))
        options["sensor_of_feature"] = [f"s{int(s)}" for s in rng.integers(0, n_sensors, p)]
        n_present = len(set(options["sensor_of_feature"]))  # type: ignore[call-overload]
        options["sensor_cost"] = rng.integers(0, 4, n_present).astype(float)
        options["sensor_budget"] = float(rng.integers(0, 6))
    return Problem(features, targets, **options)  # type: ignore[arg-type]
