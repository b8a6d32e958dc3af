"""Random problems and trees for hypothesis and for the fuzzers: small, and full of what breaks solvers.

Ties, duplicate samples, constant features, weights of zero, integer and real weights, lopsided costs, leaf sizes,
penalties, sensors that several features share, budgets, forbidden features, two to six classes.
"""

import numpy as np
from hypothesis import strategies as st
from numpy.typing import NDArray

from octmip.trees.nodes.tree import Leaf, Node, Split
from octmip.trees.question.losses import ClassCosts
from octmip.trees.question.problem import Problem
from tests.oracles.problem_options import ProblemOptions

Generator = np.random.Generator


def random_problem(rng: Generator, *, max_samples: int = 10, max_features: int = 3, max_depth: int = 3) -> Problem:
    """Return a random axis-aligned problem, each complication present with some probability of its own."""
    n, p = int(rng.integers(2, max_samples + 1)), int(rng.integers(1, max_features + 1))
    labels = _labels(rng, n)
    n_classes = int(labels.max()) + 1
    options: ProblemOptions = {"depth": int(rng.integers(1, max_depth + 1)), "class_names": tuple(range(n_classes))}
    if rng.random() < 0.4:
        options["weights"] = _weights(rng, n)
    if rng.random() < 0.3:
        options["loss"] = ClassCosts(_costs(rng, n_classes))
    if rng.random() < 0.3:
        options["leaf_size"] = int(rng.integers(1, max(2, n // 2) + 1))
    if rng.random() < 0.3:
        options["leaf_penalty"] = float(rng.choice([0.5, 1.0, 2.0, 0.3, rng.random()]))
    if rng.random() < 0.4:
        options |= _sensors(rng, p)
    if rng.random() < 0.1:
        chosen = np.flatnonzero(rng.random(p) < 0.7)
        options["allowed_splits"] = [[int(j)] for j in chosen] or [[0]]
    return Problem(_features(rng, n, p), labels, **options)


def with_missing(rng: Generator, problem: Problem) -> Problem:
    """Return a problem with some, many, nearly all or no readings missing, and at times all of one feature."""
    share = rng.choice([0.0, 0.1, 0.3, 0.6, 0.9])
    features = np.where(rng.random(problem.samples.features.shape) < share, np.nan, problem.samples.features)
    if rng.random() < 0.15:
        features[:, rng.integers(problem.samples.n_features)] = np.nan
    return problem.replace(features=features, takes_missing=bool(rng.random() < 0.5) or bool(np.isnan(features).any()))


def hyperplane_problem(rng: Generator, **sizes: int) -> Problem:
    """Return a random problem with hyperplane splits: sizes, groups and integer normals as they come."""
    axis = random_problem(rng, **sizes)
    size = int(rng.integers(2, 5)) if rng.random() < 0.5 else None
    largest = int(rng.integers(1, 8)) if rng.random() < 0.3 else None
    allowed: list[list[int]] | None = None
    if rng.random() < 0.3:
        groups = [np.flatnonzero(rng.random(axis.samples.n_features) < 0.6).tolist() for _ in range(2)]
        allowed = [group for group in groups if group] or [[0]]
    return Problem(
        axis.samples.features,
        axis.samples.targets,
        depth=axis.shape.depth,
        split="hyperplane",
        split_size=size,
        leaf_size=axis.shape.leaf_size,
        leaf_penalty=axis.shape.leaf_penalty,
        weights=axis.samples.weights,
        loss=axis.loss,
        sensor_of_feature=axis.shape.sensor_of_feature,
        sensor_cost=axis.shape.sensor_costs.tolist(),
        sensor_budget=axis.shape.sensor_budget,
        allowed_splits=allowed,
        integer_normals=largest,
        class_names=axis.samples.class_names,
    )


def _features(rng: Generator, n: int, p: int) -> NDArray[np.float64]:
    columns: list[NDArray[np.float64]] = []
    for _ in range(p):
        kind = rng.integers(5)
        if kind == 0:
            columns.append(rng.normal(size=n))
        elif kind == 1:
            columns.append(np.full(n, rng.normal()))
        elif kind == 2:
            steps = rng.integers(0, n, n).astype(np.float64)
            columns.append(900 + 1e-6 * steps)  # neighbours that float32 cannot tell apart
        else:
            columns.append(rng.integers(0, rng.integers(2, 6), n).astype(float))
    features = np.column_stack(columns)
    if rng.random() < 0.3:  # duplicate samples, their labels as they come
        features[rng.integers(n, size=n // 2)] = features[rng.integers(n, size=n // 2)]
    return features


def _labels(rng: Generator, n: int) -> NDArray[np.int64]:
    labels = rng.integers(0, rng.integers(2, 7), n)
    labels[rng.permutation(n)[:2]] = [0, 1]  # two classes at least
    return labels


def _weights(rng: Generator, n: int) -> NDArray[np.float64]:
    kind = rng.integers(4)
    if kind == 0:
        weights = rng.integers(0, 4, n).astype(float)
    elif kind == 1:
        weights = rng.choice([0.5, 1.0, 2.25], n)
    elif kind == 2:
        weights = rng.random(n) * 10.0 ** rng.integers(-3, 4)
    else:
        weights = rng.integers(1, 1000, n).astype(float)
    weights[0] = max(weights[0], 1.0)
    return weights


def _costs(rng: Generator, k: int) -> NDArray[np.float64]:
    kind = rng.integers(4)
    if kind == 0:
        state = np.arange(k)
        return np.asarray(np.abs(state[:, None] - state[None, :]) * 20.0)
    if kind == 1:
        return rng.integers(0, 5, (k, k)).astype(float)  # the diagonal too: a right answer may cost something
    if kind == 2:
        return rng.random((k, k)) * (1 - np.eye(k))
    return rng.choice([1.0, 10.0, 0.25], (k, k)) * (1 - np.eye(k))


def _sensors(rng: Generator, p: int) -> ProblemOptions:
    of_feature = [f"g{rng.integers(p)}" for _ in range(p)] if rng.random() < 0.5 else [f"g{j}" for j in range(p)]
    sensors = tuple(dict.fromkeys(of_feature))
    options: ProblemOptions = {"sensor_of_feature": of_feature, "sensor_budget": float(rng.integers(0, p + 1))}
    if rng.random() < 0.5:
        options["sensor_cost"] = {name: float(rng.choice([0.0, 0.5, 1.0, 2.0, 0.1])) for name in sensors}
    return options


def random_tree(rng: Generator, n_features: int, n_classes: int, depth: int) -> Node:
    """Return a random axis-aligned tree of at most `depth` levels."""
    if depth == 0 or rng.random() < 0.2:
        return Leaf(int(rng.integers(n_classes)))
    sides = [random_tree(rng, n_features, n_classes, depth - 1) for _ in range(2)]
    return Split(int(rng.integers(n_features)), float(rng.normal()), *sides)


@st.composite
def problems(draw: st.DrawFn, /, **limits: int) -> Problem:
    """Draw a problem; what hypothesis shrinks is the seed, so that a failing case is named by one number."""
    seed = draw(st.integers(0, 2**32 - 1))
    return random_problem(np.random.default_rng(seed), **limits)


@st.composite
def trees(draw: st.DrawFn, n_features: int = 3, n_classes: int = 3, depth: int = 3) -> Node:
    """Draw an axis-aligned tree, likewise."""
    return random_tree(np.random.default_rng(draw(st.integers(0, 2**32 - 1))), n_features, n_classes, depth)
