"""Random small problems over the whole range of float64, full of what breaks scaling, grids of costs and tolerances.

Features from denormals to the largest number, neighbours one last place apart, both zeros, ties and constants; weights,
costs and penalties from 1e-12 to 1e12 within one problem; rare classes; all settings of a Problem.
"""

from typing import Literal

import numpy as np
from numpy.typing import NDArray

from octmip.trees.losses import ClassCosts
from octmip.trees.problem import Problem
from tests.oracles.problem_options import ProblemOptions

Generator = np.random.Generator
Floats = NDArray[np.float64]
LARGEST = float(np.finfo(np.float64).max)
TINY = (5e-324, -5e-324, 2.2250738585072014e-308, 1e-300, -1e-300)
EXTREMES = np.array([0.0, -0.0, *TINY, np.nextafter(1.0, 0.0), 1.0, 1e300, -1e300, LARGEST, -LARGEST])


def wide_problem(rng: Generator, *, split: Literal["axis", "hyperplane"] = "axis", max_samples: int = 7) -> Problem:
    """Return a random problem of the kind "axis" or "hyperplane" that exact enumeration can answer.

    Hyperplanes have at most two features per split and depth 2 at most, axis-aligned trees depth 3 at most.
    """
    n, p = int(rng.integers(2, max_samples + 1)), int(rng.integers(1, 4))
    is_axis = split == "axis"
    labels, n_classes = _labels(rng, n, int(rng.integers(2, 5)))
    options: ProblemOptions = {"class_names": tuple(range(n_classes)), "split": split}
    options["depth"] = int(rng.integers(1, 4 if is_axis and n <= 6 else 3))
    if not is_axis:
        options["split_size"] = int(rng.integers(1, 3))
        if p <= 2 and rng.random() < 0.15:
            options["integer_normals"] = int(rng.integers(1, 4))
    options |= _more_options(rng, n, p, n_classes)
    return Problem(_features(rng, n, p), labels, **options)


def _more_options(rng: Generator, n: int, p: int, n_classes: int) -> ProblemOptions:
    """Return what else may be asked of n samples of p features."""
    options: ProblemOptions = {}
    if rng.random() < 0.5:
        options["weights"] = numbers(rng, n)
        options["weights"][int(rng.integers(n))] = 10.0 ** rng.uniform(-12, 12)
    if rng.random() < 0.35:
        options["loss"] = ClassCosts(_costs(rng, n_classes))
    if rng.random() < 0.3:
        options["leaf_size"] = int(rng.integers(1, max(2, n // 2) + 1))
    if rng.random() < 0.3:
        options["leaf_penalty"] = float(numbers(rng, 1)[0])
    if rng.random() < 0.3:
        options |= _sensors(rng, p)
    if rng.random() < 0.1:
        options["allowed_splits"] = [[int(j) for j in np.flatnonzero(rng.random(p) < 0.7)] or [0]]
    return options


def sized_problem(rng: Generator) -> Problem:
    """Return an axis-aligned problem that is large in one way: samples, classes, features or depth.

    Beyond the sizes at which the core changes its ways: 3 and 5 features at the root, depth 3 and 4, 8 and 16 classes,
    64 sets of labels, cuts 64 at a time, 512 samples.
    """
    way = str(rng.choice(["samples", "classes", "features", "depth"]))
    depth = int(rng.integers(3, 6) if way == "depth" else rng.integers(1, 3))
    n, p, k = {
        "samples": (int(rng.integers(20, 700 if depth == 1 else 90)), int(rng.integers(1, 3)), int(rng.integers(2, 5))),
        "classes": (int(rng.integers(20, 50)), int(rng.integers(1, 3)), int(rng.integers(7, 19))),
        "features": (int(rng.integers(6, 13)), int(rng.integers(4, 9)), 3),
        "depth": (int(rng.integers(6, 11)), 2, int(rng.integers(2, 6))),
    }[way]
    labels, _ = _labels(rng, n, k)
    options: ProblemOptions = {"class_names": tuple(range(k)), "depth": depth}
    options |= _more_options(rng, n, p, k)
    return Problem(_features(rng, n, p), labels, **options)


def sized_lines(rng: Generator) -> Problem:
    """Return a problem of splits over two features: more points than are parted one by one, more slopes than bins."""
    depth = int(rng.integers(1, 3))
    n, k = int(rng.integers(15, 61 if depth == 1 else 19)), int(rng.integers(2, 5))
    steps = int(rng.choice([4, 12, 1000]))
    features = rng.integers(0, steps, (n, 2)).astype(float)
    if rng.random() < 0.2:  # nearly all points on one line
        features[:, 1] = 2 * features[:, 0] + (rng.random(n) < 0.1)
    labels, _ = _labels(rng, n, k)
    options: ProblemOptions = {"class_names": tuple(range(k)), "depth": depth, "split": "hyperplane", "split_size": 2}
    if rng.random() < 0.3:
        options["weights"] = rng.integers(1, 9, n).astype(float)
    if rng.random() < 0.3:
        options["leaf_penalty"] = 1.0
    return Problem(features, labels, **options)


def numbers(rng: Generator, n: int) -> Floats:
    """Return n numbers of 0 or more: whole or real, alike or spread over up to 24 orders of magnitude."""
    kind = rng.integers(6)
    if kind == 0:
        return rng.integers(0, 4, n).astype(float)
    if kind == 1:
        return np.asarray(np.floor(10.0 ** rng.uniform(0, 12, n)), dtype=np.float64)
    if kind == 2:
        return np.round(10.0 ** rng.uniform(11.9, 12.1, n))
    if kind == 3:
        return np.asarray(10.0 ** rng.uniform(-12, 12) * rng.random(n), dtype=np.float64)
    if kind == 4:
        return np.asarray(rng.choice([0.1, 0.2, 0.3, 0.7], n))
    return 10.0 ** rng.uniform(-12, 12, n)


def _labels(rng: Generator, n: int, n_classes: int) -> tuple[NDArray[np.int64], int]:
    labels = rng.integers(0, n_classes, n) if rng.random() < 0.7 else np.zeros(n, dtype=np.int64)
    labels[rng.permutation(n)[:2]] = [0, 1]  # two classes at least; in the other case one is rare
    return labels, n_classes


def _costs(rng: Generator, k: int) -> Floats:
    costs = numbers(rng, k * k).reshape(k, k)
    if rng.random() < 0.7:
        np.fill_diagonal(costs, 0.0)
    return costs


def _sensors(rng: Generator, p: int) -> ProblemOptions:
    names = [f"s{int(rng.integers(p))}" for _ in range(p)] if rng.random() < 0.5 else [f"s{j}" for j in range(p)]
    sensors = list(dict.fromkeys(names))
    prices = numbers(rng, len(sensors)).tolist() if rng.random() < 0.3 else [1.0] * len(sensors)
    return {"sensor_of_feature": names, "sensor_cost": prices, "sensor_budget": float(rng.choice([0.0, 1.0, 2.0]))}


def _features(rng: Generator, n: int, p: int) -> Floats:
    columns = [_column(rng, n) for _ in range(p)]
    features = np.column_stack(columns)
    if rng.random() < 0.25:  # equal samples, their labels as they come
        features[rng.integers(n, size=n // 2)] = features[rng.integers(n, size=n // 2)]
    return features


def _column(rng: Generator, n: int) -> Floats:
    kind = rng.integers(9)
    if kind == 0:
        return rng.normal(size=n)
    if kind == 1:
        return np.full(n, rng.choice(EXTREMES))
    if kind == 2:
        return rng.integers(0, 4, n).astype(float)
    if kind == 3:  # neighbours one last place apart
        start = float(rng.choice([1.0, 900.1, 1e-310, -1e300, 0.1]))
        return np.asarray(start + np.spacing(start) * rng.integers(0, 4, n), dtype=np.float64)
    if kind == 4:
        return np.asarray(rng.choice(EXTREMES, n))
    if kind == 5:
        return np.asarray(rng.choice([-1.0, 1.0], n)) * 10.0 ** rng.uniform(-320, 308, n)
    if kind == 6:  # all of one sign at the end of the range
        return LARGEST * rng.uniform(0.4, 1.0, n)
    if kind == 7:
        return np.asarray(5e-324 * rng.integers(-4, 5, n), dtype=np.float64)
    return np.asarray(900 + 1e-6 * rng.integers(0, n, n), dtype=np.float64)
