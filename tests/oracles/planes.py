"""The best tree of hyperplanes over all features, by enumeration of every way in which planes part samples.

In general position a plane may be turned until it passes through as many samples as there are features, and these may
then fall to either side; so the planes through all such sets of samples, with every choice of sides for the samples on
them, part the samples in every way there is. Costs are whole numbers.
"""

import itertools
from fractions import Fraction

import numpy as np
from numpy.typing import NDArray

from octmip.trees.question.problem import Problem

MOST_SAMPLES = {(1, 2): 30, (1, 3): 24, (1, 4): 16, (2, 2): 22, (2, 3): 16, (2, 4): 12}
"""By depth and features."""


def random_planes(rng: np.random.Generator) -> Problem:
    """Return a random problem of hyperplanes over all of 2 to 4 features, its samples in general position."""
    depth, n_features, n_classes = int(rng.integers(1, 3)), int(rng.integers(2, 5)), int(rng.integers(2, 6))
    n = int(rng.integers(10, MOST_SAMPLES[depth, n_features] + 1))
    labels = np.r_[np.arange(n_classes), rng.integers(0, n_classes, n - n_classes)]
    weights = rng.integers(1, 4, n).astype(float) if rng.random() < 0.4 else np.ones(n)
    features = rng.normal(size=(n, n_features))
    return Problem(features, labels, depth=depth, split="hyperplane", weights=weights)


def least_cost_of_planes(problem: Problem) -> Fraction:
    """Return the least cost of any tree of a problem as `random_planes` draws them."""
    samples = problem.samples
    costs = np.eye(len(samples.class_names))[samples.codes] * samples.weights[:, None]
    parts = _parts(samples.features)

    def leaf(chosen: NDArray[np.float64]) -> NDArray[np.float64]:
        counts = chosen @ costs
        return np.asarray(counts.sum(axis=-1) - counts.max(axis=-1))

    def best(chosen: NDArray[np.float64], depth: int) -> float:
        if depth == 0:
            return float(leaf(chosen))
        if depth == 1:
            return float((leaf(parts * chosen) + leaf((1 - parts) * chosen)).min())
        key = (chosen.tobytes(), depth)
        if key not in known:
            known[key] = min(best(part * chosen, depth - 1) + best((1 - part) * chosen, depth - 1) for part in parts)
        return known[key]

    known: dict[tuple[bytes, int], float] = {}
    return Fraction(best(np.ones(samples.n_samples), problem.shape.depth))


def _parts(features: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return which samples lie on one side (n_ways, n_samples), of every plane; all of them on one is a way too."""
    n, n_features = features.shape
    lifted, found = np.c_[features, np.ones(n)], {np.ones(n, bool).tobytes()}
    for on_plane in map(list, itertools.combinations(range(n), n_features)):
        side = lifted @ np.linalg.svd(lifted[on_plane])[2][-1] > 0
        for sides in itertools.product((False, True), repeat=n_features):
            side[on_plane] = sides
            found.add(side.tobytes())
    return np.array([np.frombuffer(way, bool) for way in sorted(found)], float)
