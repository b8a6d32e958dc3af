"""What must not matter to the exact solver, and what may only help: relations between answers, on larger problems."""

import dataclasses

import numpy as np
import pytest

from benchmarks.oracles.strategies import random_problem
from octmip import ClassCosts, Problem, predict
from octmip.trees.methods.exact import branch_and_bound

SEEDS = range(12)


def larger(seed, **changes):
    """Return a random problem of 60 samples and 4 features, beyond enumeration."""
    rng = np.random.default_rng([51, seed])
    features = np.column_stack(
        [rng.normal(size=60), rng.integers(0, 6, 60), rng.normal(size=60).round(1), rng.random(60)]
    )
    labels = (features[:, 0] + features[:, 1] + rng.normal(size=60) > 2.5).astype(int) + (features[:, 2] > 0.5)
    return Problem(features, labels, **({"depth": int(rng.integers(2, 4))} | changes))


def objective(problem, **options):
    solution = branch_and_bound(problem, **options)
    assert solution.is_optimal
    return solution.objective


@pytest.mark.parametrize("seed", SEEDS)
def test_samples_features_and_labels_in_another_order_change_nothing_but_names(seed):
    problem, rng = larger(seed), np.random.default_rng(seed)
    rows, columns = rng.permutation(60), rng.permutation(4)
    renamed = np.array(["c", "a", "b"])[problem.codes]
    other = Problem(problem.features[rows][:, columns], renamed[rows], depth=problem.depth)
    assert objective(other) == objective(problem)


@pytest.mark.parametrize("seed", SEEDS)
def test_a_sample_twice_is_a_sample_of_weight_two(seed):
    problem = larger(seed)
    weights = np.random.default_rng(seed).integers(0, 3, 60)
    twice = Problem(
        np.repeat(problem.features, weights, axis=0), np.repeat(problem.targets, weights), depth=problem.depth
    )
    assert objective(twice) == objective(dataclasses.replace(problem, weights=weights))


@pytest.mark.parametrize("seed", SEEDS)
def test_growing_maps_of_the_features_change_no_prediction(seed):
    problem = larger(seed)
    mapped = dataclasses.replace(problem, features=np.sinh(problem.features / 3) * 1e3 + 7)
    one, other = branch_and_bound(problem), branch_and_bound(mapped)
    assert one.objective == other.objective
    assert (predict(one.tree, problem.features) == predict(other.tree, mapped.features)).all()


@pytest.mark.parametrize("seed", SEEDS)
def test_more_depth_more_budget_and_smaller_leaves_are_never_worse(seed):
    depths = [objective(larger(seed, depth=depth)) for depth in (1, 2, 3)]
    assert depths == sorted(depths, reverse=True)
    budgets = [objective(larger(seed, depth=2, sensor_budget=budget)) for budget in (0, 1, 2, 3, 4)]
    assert budgets == sorted(budgets, reverse=True)
    assert budgets[-1] == depths[1]
    leaves = [objective(larger(seed, depth=2, leaf_size=size)) for size in (1, 3, 10, 30)]
    assert leaves == sorted(leaves)
    assert leaves[0] == depths[1]


@pytest.mark.parametrize("seed", SEEDS)
def test_costs_and_weights_in_another_unit_are_the_same_question(seed):
    problem = random_problem(np.random.default_rng([52, seed]))
    scaled = dataclasses.replace(
        problem, weights=problem.weights * 4, loss=ClassCosts(problem.costs * 8), leaf_penalty=problem.leaf_penalty * 32
    )
    assert objective(scaled) == pytest.approx(32 * objective(problem), rel=1e-9, abs=1e-9)


def test_a_column_that_float32_cannot_hold_is_separated_without_error():
    column = (900 + 1e-6 * np.arange(40))[:, None]
    labels = (np.arange(40) >= 13).astype(int)
    assert (column.astype(np.float32) == np.float32(900)).sum() > 20
    assert objective(Problem(column, labels, depth=1)) == 0
