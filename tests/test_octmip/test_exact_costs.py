"""The exact solver under cost matrices: against enumeration, and against itself with its bounds off."""

import numpy as np
import pytest

from benchmarks.oracles.enumeration import optimum
from octmip import certify
from octmip.methods.exact import branch_and_bound
from octmip.methods.native_call import without
from octmip.problem import Problem

BLOCK = 50
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
    return Problem(features, labels, depth=depth, costs=costs, weights=weights, class_names=tuple(range(k)), **options)


@pytest.mark.parametrize("first", range(0, 600, BLOCK))
def test_it_finds_the_optimum_of_enumeration_under_any_costs(first):
    for seed in range(first, first + BLOCK):
        rng = np.random.default_rng([71, seed])
        problem = cost_problem(rng, int(rng.integers(7, 12)), int(rng.integers(1, 3)), int(rng.integers(1, 4)))
        solution = branch_and_bound(problem)
        assert certify(problem, solution).objective == solution.bound == optimum(problem).objective, f"seed {seed}"


@pytest.mark.parametrize("first", range(0, 200, BLOCK))
def test_the_optimum_stays_without_the_bounds_of_costs(first):
    for seed in range(first, first + BLOCK):
        rng = np.random.default_rng([72, seed])
        problem = cost_problem(rng, int(rng.integers(30, 90)), int(rng.integers(1, 5)), int(rng.integers(2, 4)))
        solution = branch_and_bound(problem)
        with without(*COST_BOUNDS):
            plain = branch_and_bound(problem)
        assert certify(problem, solution).objective == solution.bound == plain.objective == plain.bound, f"seed {seed}"
