"""Local search: what every tree it returns must hold, against enumeration and certificate."""

import math
import time

import numpy as np
import pytest

from octmip import HyperplaneSplit, Leaf, Limits, Problem, Split, Stop, certify
from octmip.errors import ProblemError
from octmip.trees.methods.exact import branch_and_bound
from octmip.trees.methods.merging import merged
from octmip.trees.methods.options import SearchOptions
from octmip.trees.methods.polish import polished
from octmip.trees.methods.search import local_search
from octmip.trees.methods.two_feature import two_feature_branch_and_bound
from octmip.trees.nodes.tree import leaf_index, predict, splits
from tests.oracles.enumeration import optimum
from tests.oracles.strategies import random_problem
from tests.oracles.two_feature_problems import random_two_feature_problem

NOISE = np.random.default_rng(1)
LARGE = Problem(NOISE.normal(size=(400, 6)), NOISE.integers(0, 4, 400), depth=4)


def test_random_problems_get_feasible_trees_with_true_objectives_seldom_above_the_optimum():
    rng = np.random.default_rng(2)
    n_missed = 0
    for seed in range(80):
        problem = random_problem(rng)
        solution = local_search(problem, seed=seed, options=SearchOptions(restarts=5))
        certify(problem, solution)
        best = optimum(problem).objective
        assert solution.objective >= best - 1e-9 * max(1.0, best)
        n_missed += solution.objective > best + 1e-9 * max(1.0, best)
    assert n_missed <= 3


def test_perturbations_of_deep_trees_keep_every_constraint_and_the_objective_of_the_certificate():
    rng = np.random.default_rng(5)
    seen = set()
    for seed in range(60):
        problem = random_problem(rng, max_samples=40, max_features=5, max_depth=4)
        if problem.shape.depth < 3:
            continue  # cuts are shifted and subtrees rebuilt from three levels on
        solution = local_search(problem, seed=seed, options=SearchOptions(restarts=2, perturbations=6))
        certificate = certify(problem, solution)
        assert certificate.objective == pytest.approx(solution.objective)
        seen |= {name for name, is_on in _complications(problem).items() if is_on}
    assert seen == set(_complications(LARGE))


def _complications(problem):
    return {
        "weights": len(set(problem.samples.weights)) > 1,
        "costs": not np.array_equal(problem.costs, 1 - np.eye(len(problem.costs))),
        "leaf_size": problem.shape.leaf_size > 1,
        "leaf_penalty": problem.shape.leaf_penalty > 0,
        "sensor_budget": problem.shape.sensor_budget is not None,
        "allowed_splits": problem.shape.allowed_splits is not None,
    }


def test_one_seed_is_one_tree_for_any_number_of_threads_even_when_the_bound_is_reached_early():
    rng = np.random.default_rng(4)
    for seed in range(20):
        features = rng.integers(0, 4, (60, 3)).astype(float)
        problem = Problem(features, (features[:, 0] > 1) ^ (features[:, 1] > 2), depth=2)
        alone, together = (local_search(problem, seed=seed, n_jobs=n) for n in (1, 3))
        assert alone.tree == together.tree


def test_no_cost_left_is_a_proof_and_any_other_tree_has_no_bound():
    separable = Problem([[0.0], [1.0]], [0, 1], depth=1)
    solved = local_search(separable)
    assert solved.is_optimal
    assert solved.bound == 0.0
    assert solved.stop is Stop.OPTIMAL
    open_end = local_search(LARGE, options=SearchOptions(restarts=1, perturbations=0))
    assert open_end.bound == -math.inf
    assert open_end.stop is Stop.FINISHED


def test_neighbours_that_float32_cannot_tell_apart_are_separated_and_thresholds_lie_in_mid_gap():
    features = 900 + 1e-6 * np.arange(40.0)[:, None]
    solution = local_search(Problem(features, np.arange(40) >= 17, depth=1))
    assert solution.objective == 0
    assert isinstance(solution.tree, Split)
    assert solution.tree.threshold == pytest.approx(900 + 16.5e-6, abs=1e-12)


def test_the_penalty_buys_no_split_that_does_not_pay():
    features = np.arange(10.0)[:, None]
    labels = np.arange(10) == 9
    cheap, even, expensive = (
        local_search(Problem(features, labels, depth=2, leaf_penalty=penalty)) for penalty in (0.5, 1.0, 1.5)
    )
    assert isinstance(cheap.tree, Split)
    assert even.objective == 1.0  # with the split and without it
    assert isinstance(expensive.tree, Leaf)


def test_a_node_limit_ends_the_search():
    assert local_search(LARGE, limits=Limits(nodes=50), options=SearchOptions(restarts=10**6)).stop is Stop.NODES


def test_progress_is_reported_and_what_it_raises_is_raised():
    seen = []
    local_search(LARGE, options=SearchOptions(restarts=10**6), limits=Limits(seconds=0.4), progress=seen.append)
    assert seen
    assert all(state.seconds >= 0 for state in seen)

    def fail(state):
        raise ValueError("from the callback")

    with pytest.raises(ValueError, match="from the callback"):
        local_search(LARGE, options=SearchOptions(restarts=10**6), limits=Limits(seconds=60), progress=fail)


def test_no_threads_are_refused():
    with pytest.raises(ProblemError, match="n_jobs is 0; expected 1 or more"):
        local_search(LARGE, n_jobs=0)


def test_features_of_many_samples_are_compared_on_a_part_and_the_best_one_is_found():
    rng = np.random.default_rng(0)
    features = rng.normal(size=(30_000, 40))  # too many for exact blocks, so that the node is visited
    noisy = rng.random(30_000) < 0.1
    problem = Problem(features, (features[:, 4] > 0.3) ^ noisy, depth=1)
    found = local_search(
        problem, options=SearchOptions(restarts=1, perturbations=0), incumbent=Split(2, 0.0, Leaf(0), Leaf(1))
    )
    assert found.tree.feature == 4
    assert found.objective == branch_and_bound(problem).objective


def test_small_searches_are_never_better_than_the_proven_optimum_and_mostly_at_it():
    n_hits = 0
    for seed in range(24):
        problem = random_two_feature_problem(np.random.default_rng([72, seed]), depth=1 + seed % 2, max_samples=30)
        found, best = (
            local_search(problem, seed=seed, options=SearchOptions(restarts=3)),
            two_feature_branch_and_bound(problem),
        )
        certify(problem, found)
        assert best.is_optimal
        assert found.objective >= best.bound - best.tolerance
        n_hits += found.objective <= best.objective + best.tolerance
    assert n_hits >= 22


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


LARGEST, TINIEST, NORMAL = np.finfo(np.float64).max, 5e-324, np.finfo(np.float64).tiny
BELOW_ONE, ABOVE_ONE = np.nextafter(1.0, 0.0), np.nextafter(1.0, 2.0)
VALUES = [NORMAL, 1e-300, 1.0, ABOVE_ONE, BELOW_ONE, 3.0]
VALUES += [sign * size for size in (TINIEST, 1e300, LARGEST, 0.0) for sign in (1.0, -1.0)]


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


FEATURES = [[1.0, 2.0], [0.0, 5.0], [1.0, 2.0], [1.0, 2.0], [-0.0, 5.0]]


def test_rows_without_weight_are_left_out_unless_they_make_up_a_class_or_lie_far_outside():
    problem = Problem(FEATURES, ["a", "b", "a", "b", "b"], depth=1, weights=[1, 2, 0, 4, 0])
    assert merged(problem)[0].samples.n_samples == 3
    assert merged(problem.replace(weights=[1, 0, 3, 0, 0]))[0].samples.n_samples == 3
    far = Problem([*FEATURES, [1e300, 0.0]], ["a", "b", "a", "b", "b", "a"], depth=1, weights=[1, 2, 3, 4, 1, 0])
    assert merged(far)[0].samples.n_samples == 4


@pytest.mark.parametrize("options", [{}, {"split": "hyperplane"}, {"split": "hyperplane", "split_size": 2}])
def test_weights_and_repeated_rows_in_any_order_get_the_same_tree(options):
    rng = np.random.default_rng(31)
    for seed in range(4):
        features = np.round(rng.normal(size=(40, 3)), 1)
        labels, weights = rng.integers(0, 3, 40), rng.integers(0, 4, 40)
        labels[:3], weights[:3] = [0, 1, 2], 1
        weighed = Problem(features, labels, depth=3, weights=weights.astype(float), **options)
        rows = rng.permutation(np.repeat(np.arange(40), weights))
        repeated = Problem(features[rows], labels[rows], depth=3, **options)
        first, second = (
            local_search(problem, seed=seed, options=SearchOptions(restarts=2, perturbations=4))
            for problem in (weighed, repeated)
        )
        certify(weighed, first)
        assert first.tree == second.tree
        assert first.objective == second.objective
