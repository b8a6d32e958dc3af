"""Local search over hyperplanes: every limit of the problem holds, and the float rule of the tree decides."""

import math

import numpy as np
import pytest

from octmip import HyperplaneSplit, Problem
from octmip.trees.methods.options import SearchOptions
from octmip.trees.methods.search import local_search
from octmip.trees.nodes.tree import splits


def test_hyperplanes_are_never_worse_than_the_axis_aligned_search():
    rng = np.random.default_rng(12)
    for seed in range(10):
        features, labels = rng.normal(size=(80, 4)), rng.integers(0, 3, 80)
        options = {"depth": 2, "weights": rng.integers(1, 5, 80).astype(float)}
        axis = local_search(Problem(features, labels, **options), seed=seed)
        planes = local_search(
            Problem(features, labels, split="hyperplane", **options), seed=seed, options=SearchOptions(restarts=2)
        )
        assert planes.objective <= axis.objective


def test_one_hyperplane_separates_what_one_can():
    rng = np.random.default_rng(13)
    features = rng.normal(size=(200, 5))
    labels = features @ [1.0, -2.0, 0.5, 0.0, 3.0] > 0.3
    solution = local_search(Problem(features, labels, depth=1, split="hyperplane"))
    assert solution.objective == 0
    assert solution.is_optimal
    assert isinstance(solution.tree, HyperplaneSplit)


@pytest.mark.parametrize("most", [1, 3])
def test_integer_normals_are_integers_within_their_limit(most):
    rng = np.random.default_rng(16)
    features = rng.normal(size=(120, 3))
    labels = features @ [1.0, 1.0, -1.0] > 0.2
    problem = Problem(features, labels, depth=1, split="hyperplane", integer_normals=most)
    solution = local_search(problem)
    assert solution.objective == 0
    for split in splits(solution.tree):
        if isinstance(split, HyperplaneSplit):
            assert all(c == math.floor(c) and abs(c) <= most for c in split.coefficients)
