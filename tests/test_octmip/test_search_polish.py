"""Polishing: simpler hyperplanes that part every sample as before; and what every searched tree must hold."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from octmip import HyperplaneSplit, Leaf, Problem, certify
from octmip.trees.methods.margin import width
from octmip.trees.methods.options import SearchOptions
from octmip.trees.methods.polish import polished
from octmip.trees.methods.search import local_search
from octmip.trees.nodes.tree import Node, leaf_index, splits
from tests.oracles.strategies import hyperplane_problem


def random_hyperplanes(rng, problem: Problem, depth: int) -> Node:
    """Return a tree of random hyperplanes through random samples, integer normals where the problem wants them."""
    if depth == 0:
        return Leaf(0)
    features = np.flatnonzero(rng.random(problem.samples.n_features) < 0.7)
    if len(features) == 0:
        return Leaf(0)
    normal = rng.integers(1, 4, len(features)) * rng.choice([-1.0, 1.0], len(features))
    if problem.shape.integer_normals is None:
        normal = rng.normal(size=len(features))
    heights = problem.samples.features[:, features] @ normal
    return HyperplaneSplit(
        tuple(int(f) for f in features),
        tuple(float(c) for c in normal),
        float(rng.choice(heights)),
        random_hyperplanes(rng, problem, depth - 1),
        random_hyperplanes(rng, problem, depth - 1),
    )


@settings(max_examples=60, deadline=None)
@given(st.integers(0, 2**32))
def test_every_sample_stays_in_its_leaf_and_no_plane_gains_a_feature(seed):
    rng = np.random.default_rng(seed)
    problem = hyperplane_problem(rng, max_samples=40, max_features=5)
    tree = random_hyperplanes(rng, problem, 3)
    simple = polished(problem, tree)
    assert np.array_equal(leaf_index(simple, problem.samples.features), leaf_index(tree, problem.samples.features))
    for before, after in zip(splits(tree), splits(simple), strict=True):
        assert set(after.features) <= set(before.features)
        if problem.shape.integer_normals is not None:
            assert set(after.coefficients) <= set(before.coefficients)


def test_needless_features_go_and_numbers_become_short_and_offsets_lie_in_mid_gap():
    rng = np.random.default_rng(1)
    features = rng.normal(size=(100, 4))
    features[:, 0] += np.where(np.arange(100) < 50, -10.0, 10.0)
    problem = Problem(features, np.arange(100) >= 50, depth=1, split="hyperplane")
    clumsy = HyperplaneSplit((0, 1, 3), (0.337192, 0.00013, -0.00021), 0.2, Leaf(0), Leaf(1))
    simple = polished(problem, clumsy)
    assert (simple.features, simple.coefficients) == ((0,), (1.0,))
    low, high = features[:50, 0].max(), features[50:, 0].min()
    assert low + (high - low) / 3 <= simple.offset <= high - (high - low) / 3
    assert len(repr(simple.offset)) <= 4


@pytest.mark.long
@settings(max_examples=60, deadline=None)
@given(st.integers(0, 2**32))
def test_the_margin_is_nine_tenths_of_the_widest_over_all_angles(seed):
    rng = np.random.default_rng(seed)
    features = rng.normal(size=(rng.integers(2, 60), 2)) * [1.0, 30.0]
    heights = features @ [1.0, 0.02]
    left = heights <= np.sort(heights)[rng.integers(0, len(heights) - 1)]
    features[~left] += [0.1, 3.0]
    problem = Problem(features, ~left, depth=1, split="hyperplane")
    offset = float((features @ [1.0, 0.02])[left].max())
    simple = polished(problem, HyperplaneSplit((0, 1), (1.0, 0.02), offset, Leaf(0), Leaf(1)))
    if len(simple.features) == 1:  # fewer features come before margins
        return
    points, spread = features / features.std(axis=0), features.std(axis=0)
    angles = np.linspace(0.0, 2 * np.pi, 2000)
    widest = max(width(points, np.array([np.cos(angle), np.sin(angle)]), left) for angle in angles)
    assert width(points, np.array(simple.coefficients) * spread, left) >= 0.89 * widest > 0


@settings(max_examples=25, deadline=None)
@given(st.integers(0, 2**32))
def test_no_searched_tree_breaks_a_limit_or_has_another_objective_than_its_certificate(seed):
    rng = np.random.default_rng(seed)
    problem = hyperplane_problem(rng, max_samples=30, max_features=4, max_depth=3)
    for restarts, perturbations in ((1, 0), (3, 6)):
        options = SearchOptions(restarts=restarts, perturbations=perturbations)
        solution = local_search(problem, seed=seed % 97, options=options)
        certify(problem, solution)
        # Polished once more it may lose another feature, and its price with it.
        again = polished(problem, solution.tree)
        objective = problem.objective(again)
        assert objective <= solution.objective + 1e-9 * max(1.0, solution.objective)
        certify(problem, replace(solution, tree=again, objective=objective))


@pytest.mark.parametrize("n_steps", range(6))
def test_polishing_that_is_stopped_at_any_step_moves_no_sample(n_steps):
    rng = np.random.default_rng(n_steps)
    problem = Problem(rng.normal(size=(40, 3)), rng.integers(0, 2, 40), depth=1, split="hyperplane")
    plane = HyperplaneSplit((0, 1, 2), (0.123456789, 1.0, -0.777), 0.1, Leaf(0), Leaf(1))
    left = iter(range(n_steps))
    stopped = polished(problem, plane, lambda: next(left, None) is not None)
    assert np.array_equal(leaf_index(stopped, problem.samples.features), leaf_index(plane, problem.samples.features))
