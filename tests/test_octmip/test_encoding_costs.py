"""Weights and costs as whole numbers: exact where they can be, rounded down and said so elsewhere."""

import math

import numpy as np
import pytest

from benchmarks.oracles.strategies import random_problem
from octmip import Problem
from octmip.encoding import integer_costs

X, Y = np.arange(6.0)[:, None], [0, 1, 0, 1, 1, 0]


@pytest.mark.parametrize(
    ("options", "unit"),
    [
        ({}, 1.0),
        ({"weights": [0.5, 1, 2.25, 3, 1, 1]}, 0.25),
        ({"weights": [0.5, 1, 2, 3, 1, 1], "costs": [[0, 0.25], [1, 0]]}, 0.125),
        ({"leaf_penalty": 0.375}, 0.125),
        ({"weights": [1e9] * 6}, 1.0),
    ],
)
def test_dyadic_numbers_are_whole_in_the_largest_unit(options, unit):
    costs = integer_costs(Problem(X, Y, depth=1, **options))
    assert (costs.unit, costs.tolerance) == (unit, 0.0)


@pytest.mark.parametrize("seed", range(150))
def test_rounding_goes_down_and_stays_within_the_tolerance(seed):
    problem = random_problem(np.random.default_rng([3, seed]))
    costs = integer_costs(problem)
    held = (costs.weights * costs.unit)[:, None] * costs.costs[problem.codes]
    true = problem.weights[:, None] * problem.costs[problem.codes]
    assert (held <= true * (1 + 1e-15)).all()
    assert (true - held).sum() <= costs.tolerance * problem.n_classes
    assert costs.tolerance <= 1e-6 * true.max(axis=1).sum()


def test_many_real_weights_and_real_costs_are_told_apart_to_a_millionth_of_the_worst():
    rng = np.random.default_rng(0)
    problem = Problem(
        rng.random((2000, 1)), np.arange(2000) % 3, depth=1, weights=rng.random(2000), costs=rng.random((3, 3))
    )
    assert integer_costs(problem).tolerance < 1e-6 * problem.weights.sum()


def test_a_penalty_above_every_cost_is_cut_to_just_above_without_loss():
    costs = integer_costs(Problem(X, Y, depth=2, leaf_penalty=1e30))
    assert costs.penalty == 7 and costs.tolerance == 0.0


def test_a_large_penalty_does_not_coarsen_the_costs():
    problem = Problem(X, Y, depth=2, leaf_penalty=math.pi * 1e6, weights=np.full(6, 1e-3))
    assert integer_costs(problem).tolerance < 1e-12
