"""Random problems for splits over one or two features: grids, duplicates, points on lines, ties, all the options."""

import numpy as np
from numpy.typing import NDArray

from octmip.trees.losses import ClassCosts
from octmip.trees.problem import Problem
from tests.oracles.problem_options import ProblemOptions


def random_two_feature_problem(rng: np.random.Generator, *, depth: int, max_samples: int) -> Problem:
    """Return a random problem that enumeration can solve, each complication present with a probability of its own."""
    n, p, k = int(rng.integers(2, max_samples + 1)), int(rng.integers(1, 4)), int(rng.integers(2, 6))
    labels = rng.integers(0, k, n)
    labels[0], labels[-1] = 0, 1
    options: ProblemOptions = {
        "depth": depth,
        "split": "hyperplane",
        "split_size": min(2, p),
        "class_names": tuple(range(k)),
    }
    if rng.random() < 0.4:
        options["weights"] = rng.integers(0, 5, n).astype(float)
        options["weights"][0] = 1.0
    if rng.random() < 0.3:
        options["loss"] = ClassCosts(rng.integers(0, 6, (k, k)).astype(float))
    if rng.random() < 0.3:
        options["leaf_size"] = int(rng.integers(1, max(2, n // 2)))
    if rng.random() < 0.4:
        options["leaf_penalty"] = float(rng.choice([1, 2, 0.5, 0.25]))
    if rng.random() < 0.3:
        options["sensor_budget"] = float(rng.integers(0, 4))
    if p == 3 and rng.random() < 0.2:
        options["sensor_of_feature"] = ["a", "a", "b"]
    if p == 3 and rng.random() < 0.2:
        options["allowed_splits"] = [[0, 1], [2]]
    return Problem(_features(rng, n, p), labels, **options)


def clouds(seed: int, *, most_samples: int = 260) -> Problem:
    """Return a problem of depth 2 whose classes follow one another in a noisy cloud: many samples, large costs."""
    rng = np.random.default_rng([62, seed])
    n, p, k = int(rng.integers(80, most_samples)), int(rng.integers(2, 5)), int(rng.integers(3, 7))
    level = rng.integers(0, k, n)
    spread = rng.normal(scale=rng.uniform(0.05, 0.6), size=(n, p))
    features = level[:, None] * np.linspace(1, 0.5, p) + spread
    return Problem(features, level, depth=2, split="hyperplane", split_size=2, class_names=tuple(range(k)))


def _features(rng: np.random.Generator, n: int, p: int) -> NDArray[np.float64]:
    pattern = rng.integers(4)
    if pattern == 0:  # a small grid: duplicates and many points on one line
        return rng.integers(0, 4, (n, p)).astype(float)
    if pattern == 1:
        return rng.normal(size=(n, p))
    if pattern == 2:  # a grid of other units in every column
        return rng.integers(0, 8, (n, p)) / 8 * 2.0 ** rng.integers(-3, 9, p)
    features = rng.integers(0, 6, (n, p)).astype(float)
    if p > 1:  # nearly all points on one line
        features[:, 1] = 2 * features[:, 0] + (rng.random(n) < 0.3)
    return features
