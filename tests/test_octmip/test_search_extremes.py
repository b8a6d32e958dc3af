"""Local search over the whole range of float64: it ends, raises and warns of nothing, and its trees are certified."""

import time

import numpy as np
import pytest

from octmip import HyperplaneSplit, Leaf, Limits, Problem, certify
from octmip.trees.methods.options import SearchOptions
from octmip.trees.methods.polish import polished
from octmip.trees.methods.search import local_search
from octmip.trees.nodes.tree import leaf_index, predict

LARGEST, TINIEST, NORMAL = np.finfo(np.float64).max, 5e-324, np.finfo(np.float64).tiny
BELOW_ONE, ABOVE_ONE = np.nextafter(1.0, 0.0), np.nextafter(1.0, 2.0)
VALUES = [
    TINIEST,
    -TINIEST,
    NORMAL,
    1e-300,
    1e300,
    -1e300,
    LARGEST,
    -LARGEST,
    0.0,
    -0.0,
    1.0,
    ABOVE_ONE,
    BELOW_ONE,
    3.0,
]


def test_features_in_other_units_by_powers_of_two_get_the_same_tree():
    rng = np.random.default_rng(22)
    features, labels = rng.normal(size=(60, 3)), rng.integers(0, 2, 60)
    units = 2.0 ** np.array([700.0, -900.0, 3.0])
    options = {"depth": 2, "split": "hyperplane", "split_size": 2}
    plain, scaled = (
        local_search(Problem(values, labels, **options), options=SearchOptions(restarts=2, perturbations=6))
        for values in (features, features * units)
    )
    assert np.array_equal(predict(plain.tree, features), predict(scaled.tree, features * units))


@pytest.mark.parametrize("seconds", [0.0, 0.05])
def test_a_large_hyperplane_problem_ends_with_its_limit(seconds):
    rng = np.random.default_rng(25)
    problem = Problem(rng.normal(size=(4000, 40)), rng.integers(0, 4, 4000), depth=8, split="hyperplane")
    start = time.process_time()
    certify(problem, local_search(problem, limits=Limits(seconds=seconds)))
    assert time.process_time() - start < 5.0


def test_polishing_keeps_every_sample_of_extreme_values_in_its_leaf():
    rng = np.random.default_rng(27)
    sizes = [value for value in VALUES if value]
    for _ in range(120):
        points = rng.choice(VALUES, (8, 2))
        problem = Problem(points, np.arange(8) % 2, depth=1, split="hyperplane")
        normal = tuple(rng.choice(sizes, 2).tolist())
        with np.errstate(over="ignore", invalid="ignore"):
            offset = float(np.nan_to_num(points[0] @ normal))
        plane = HyperplaneSplit((0, 1), normal, offset, Leaf(0), Leaf(1))
        assert np.array_equal(leaf_index(polished(problem, plane), points), leaf_index(plane, points))
