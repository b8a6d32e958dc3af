"""The exact solver under cost matrices: against enumeration, and against itself with its bounds off."""

import numpy as np
import pytest

from octmip import ClassCosts, certify
from octmip.trees.evidence.proof import check_proof
from octmip.trees.methods.exact import branch_and_bound
from octmip.trees.methods.native_call import without
from octmip.trees.methods.options import ExactOptions
from octmip.trees.question.problem import Problem
from tests.oracles.rational import least_cost

BLOCK = 30
COST_BOUNDS = ("mixed_labels", "buckets", "cost_range", "vectors")


def cost_problem(rng, n, p, depth):
    """Return samples of three to seven classes in order along the features, under some cost matrix."""
    k = int(rng.integers(3, 8))
    labels = np.concatenate([np.arange(k), rng.integers(0, k, max(n - k, 0))])[:n]
    features = labels[:, None] * rng.uniform(0, 1, p) + rng.normal(size=(len(labels), p))
    if rng.random() < 0.5:
        features = np.round(features)
    state = np.arange(k)
    kind = rng.integers(5)
    if kind == 0:
        costs = np.abs(state[:, None] - state)
    elif kind == 1:
        costs = (state[:, None] != state) * np.where(np.not_equal.outer(state > k // 2, state > k // 2), 5, 1)
    elif kind == 2:
        costs = rng.integers(0, 9, (k, k))
    elif kind == 3:
        costs = (state[:, None] - state) ** 2 * rng.integers(0, 3, (k, 1))
    else:
        costs = rng.choice([0.0, 0.5, 3.0], (k, k))
    weights = rng.integers(0, 4, n) + (np.arange(n) == 0) if rng.random() < 0.5 else np.ones(n)
    options = {"leaf_penalty": float(rng.choice([0.0, 0.0, 1.0])), "leaf_size": int(rng.choice([1, 1, 1, 2]))}
    return Problem(
        features, labels, depth=depth, loss=ClassCosts(costs), weights=weights, class_names=tuple(range(k)), **options
    )


@pytest.mark.parametrize("first", range(0, 60, BLOCK))
def test_the_optimum_stays_without_the_bounds_of_costs(first):
    for seed in range(first, first + BLOCK):
        rng = np.random.default_rng([72, seed])
        problem = cost_problem(rng, int(rng.integers(30, 90)), int(rng.integers(1, 5)), int(rng.integers(2, 4)))
        solution = branch_and_bound(problem)
        with without(*COST_BOUNDS):
            plain = branch_and_bound(problem)
        assert certify(problem, solution).objective == solution.bound == plain.objective == plain.bound, f"seed {seed}"


@pytest.mark.parametrize("seed", [0, 1, 2, 3])
def test_every_bound_of_costs_is_valid_by_itself(seed):
    rng = np.random.default_rng([76, seed])
    problem = cost_problem(rng, int(rng.integers(40, 80)), 1 + seed % 10, 3)
    least = branch_and_bound(problem).objective
    for kept in COST_BOUNDS:
        with without(*(name for name in COST_BOUNDS if name != kept)):
            alone = branch_and_bound(problem)
        assert alone.objective == alone.bound == least, kept


def in_smaller_units(problem, **options):
    """Return a problem whose costs are 20 times as much, and 7 more whatever is predicted for the first class."""
    costs = problem.costs * 20
    costs[0] += 7
    return problem.replace(loss=ClassCosts(costs), leaf_penalty=problem.shape.leaf_penalty * 20, **options)


@pytest.mark.parametrize("budget", [None, 2])
def test_costs_of_a_common_factor_are_searched_and_logged_as_without_it(budget, tmp_path):
    for seed in range(4):
        rng = np.random.default_rng([73, seed])
        problem = cost_problem(rng, 80, 4, 2 + seed % 2)
        if budget is not None:
            problem = problem.replace(sensor_budget=budget)
        finer, path = in_smaller_units(problem), tmp_path / "proof.log"
        plain, solution = branch_and_bound(problem), branch_and_bound(finer, options=ExactOptions(proof=path))
        assert (solution.tree, solution.n_nodes) == (plain.tree, plain.n_nodes), f"seed {seed}"
        assert solution.bound == solution.objective == finer.objective(plain.tree), f"seed {seed}"
        assert check_proof(finer, path).bound == solution.bound, f"seed {seed}"


@pytest.mark.parametrize("unit", [0.2, 1 / 3, 1e-7])
def test_costs_that_are_multiples_but_for_rounding_are_counted_in_whole_numbers(unit, tmp_path):
    for seed in range(3):
        rng = np.random.default_rng([75, seed])
        whole = cost_problem(rng, 60, 3, 3)
        whole = whole.replace(loss=ClassCosts(np.round(whole.costs)), leaf_penalty=np.round(whole.shape.leaf_penalty))
        problem = whole.replace(loss=ClassCosts(whole.costs * unit), leaf_penalty=whole.shape.leaf_penalty * unit)
        path = tmp_path / "proof.log"
        plain, solution = branch_and_bound(whole), branch_and_bound(problem, options=ExactOptions(proof=path))
        assert solution.objective == pytest.approx(plain.objective * unit, rel=1e-12), f"seed {seed}"
        assert (solution.stop, solution.n_nodes) == (plain.stop, plain.n_nodes), f"seed {seed}"
        assert certify(problem, solution).objective - solution.bound <= 1e-9 * solution.objective, f"seed {seed}"
        assert check_proof(problem, path).bound == solution.bound, f"seed {seed}"


@pytest.mark.parametrize("top", [1, 6, 100_000])
@pytest.mark.parametrize("n_classes", [7, 8, 9, 10, 11])
def test_many_classes_cost_the_same_by_histograms_and_by_walks(n_classes: int, top: int) -> None:
    rng = np.random.default_rng([n_classes, top])
    features, labels = rng.normal(size=(160, 4)).round(1), rng.integers(0, n_classes, 160)
    costs = rng.integers(1, top + 1, (n_classes, n_classes)) * (1 - np.eye(n_classes))
    problem = Problem(features, labels, depth=2, loss=ClassCosts(costs))
    with without("buckets"):
        walked = branch_and_bound(problem)
    found = branch_and_bound(problem)
    assert found.is_optimal
    assert found.objective == walked.objective == problem.objective(found.tree)


@pytest.mark.parametrize("max_splits", [3, 4, 5, 6])
def test_few_splits_under_costs_are_those_of_a_list_of_all_trees(max_splits):
    # Enough samples that the bound of mixed labels counts on a side of two splits.
    for seed in range(max_splits, 60, 4):
        rng = np.random.default_rng([83, seed])
        n, k = int(rng.integers(30, 45)), 4
        features = rng.integers(0, 6, (n, 2)).astype(float)
        labels = (features.sum(axis=1).astype(int) + (rng.random(n) < 0.2) * rng.integers(0, k, n)) % k
        costs = ClassCosts(rng.integers(1, 6, (k, k)) * (1 - np.eye(k)))
        weights = rng.integers(1, 5, n).astype(float)
        options = {"leaf_size": 1 + seed % 3, "leaf_penalty": float(rng.choice([0, 1])), "weights": weights}
        problem = Problem(
            features, labels, depth=3, loss=costs, class_names=tuple(range(k)), max_splits=max_splits, **options
        )
        solution = branch_and_bound(problem)
        assert (solution.is_optimal, solution.objective) == (True, least_cost(problem)), seed
