"""The best regression tree by exhaustive enumeration, and random problems for it.

The enumeration is that of classes with leaves of numbers. Imports nothing of octmip but the problem, the tree and the
name of its loss.
"""

from fractions import Fraction
from functools import cache

import numpy as np

from octmip.trees.nodes.tree import Leaf
from octmip.trees.question.losses import number_loss
from octmip.trees.question.problem import Problem
from tests.oracles.enumeration import least


def least_objective(problem: Problem) -> Fraction:
    """Return the least objective of an axis-aligned tree with the best constant in each leaf."""
    targets = [Fraction(y) for y in problem.samples.targets.tolist()]
    weights = [Fraction(w) for w in problem.samples.weights.tolist()]

    @cache
    def leaf(samples: int) -> tuple[Fraction, Leaf]:
        rows = [i for i in range(len(targets)) if samples >> i & 1]
        total = sum((weights[i] for i in rows), Fraction(0))
        if problem.loss.name == "squared":
            first = sum((weights[i] * targets[i] for i in rows), Fraction(0))
            square = sum((weights[i] * targets[i] ** 2 for i in rows), Fraction(0))
            return (square - first * first / total if total else square), Leaf(0)
        up, down = slopes_of(problem)
        misses = [[(targets[i] - targets[j]) * weights[i] for i in rows] for j in rows]
        errors = (sum((max(up * m, -down * m) for m in of), Fraction(0)) for of in misses)
        return min(errors, default=Fraction(0)), Leaf(0)

    return Fraction(least(problem, leaf, Fraction(problem.shape.leaf_penalty))[0])


def slopes_of(problem: Problem) -> tuple[Fraction, Fraction]:
    """Return what a target costs above its prediction and below it, for each unit of distance."""
    level = getattr(problem.loss, "level", None)
    if level is None:
        return Fraction(1), Fraction(1)
    above = Fraction(level).limit_denominator(1000)
    return above, 1 - above


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
