"""Weights and costs that span many orders of magnitude: the optimum, or a bound that holds."""

from fractions import Fraction

import numpy as np
import pytest

from octmip import ClassCosts, Leaf, Problem, Split, certify, predict
from octmip.errors import ProblemError
from octmip.trees.answer.solution import Stop, closing_tolerance
from octmip.trees.encoding import costs as grid
from octmip.trees.methods.exact import branch_and_bound
from octmip.trees.methods.two_feature import two_feature_branch_and_bound
from octmip.trees.nodes.tree import n_splits
from tests.oracles.enumeration import optimum
from tests.oracles.wide_problems import wide_problem

BLOCK = 30


def exact_objective(problem, tree):
    """Return the objective of a tree as the rational number that it is."""
    samples = problem.samples
    answers = zip(samples.weights.tolist(), samples.codes, predict(tree, samples.features), strict=True)
    paid = (Fraction(weight) * Fraction(float(problem.costs[code, k])) for weight, code, k in answers)
    return sum(paid, n_splits(tree) * Fraction(problem.shape.leaf_penalty))


def check(problem, solution, best):
    """Assert that a solution is the optimum within its tolerance, or leaves only what float64 cannot hold."""
    certify(problem, solution)
    assert Fraction(solution.bound) <= best
    if solution.stop is Stop.OPTIMAL:
        rounding = best / 2**52
        assert exact_objective(problem, solution.tree) - best <= Fraction(solution.tolerance) + rounding
    else:
        assert solution.stop is Stop.NUMERICS
        assert solution.tolerance == 0
        assert not solution.is_optimal


@pytest.mark.parametrize("first", range(0, 60, BLOCK))
def test_the_optimum_is_proven_unless_float64_cannot_tell_two_trees_apart(first):
    for seed in range(first, first + BLOCK):
        problem = wide_problem(np.random.default_rng([51, seed]))
        solution = branch_and_bound(problem)
        check(problem, solution, exact_objective(problem, optimum(problem).tree))
        if solution.stop is Stop.NUMERICS:
            # Half a unit in the last place of the objective, one of the bound that is rounded down.
            assert 1.5 * np.spacing(solution.objective) >= problem.least_saving, f"seed {seed}"


def test_with_weights_and_costs_rounded_each_for_itself_every_bound_still_holds(monkeypatch):
    monkeypatch.setattr(grid, "MOST_OWN_ROWS", 0)
    for seed in range(BLOCK):
        problem = wide_problem(np.random.default_rng([52, seed]))
        check(problem, branch_and_bound(problem), exact_objective(problem, optimum(problem).tree))


@pytest.mark.parametrize("scale", [1e-275, 1e-200, 1e200, 1e298])
def test_the_ends_of_float64_give_a_tree_and_a_bound_that_holds(scale):
    for seed in range(6):
        rng = np.random.default_rng([55, seed])
        n = int(rng.integers(3, 9))
        features, labels = rng.integers(0, 4, (n, 2)).astype(float), rng.integers(0, 3, n)
        labels[:2] = [0, 1]
        costs = None if seed % 2 else rng.random((3, 3))
        weights = rng.integers(1, 1000, n) * scale
        problem = Problem(features, labels, depth=2, weights=weights, loss=ClassCosts(costs), class_names=(0, 1, 2))
        check(problem, branch_and_bound(problem), exact_objective(problem, optimum(problem).tree))


@pytest.mark.parametrize(("weight", "cost"), [(1e300, 1e12), (1e303, 1.0), (1e-200, 1e-200), (5e-324, 1.0)])
def test_costs_beyond_float64_are_refused_with_a_way_out(weight, cost):
    with pytest.raises(ProblemError, match=r"expected from 1e-280 to 1e\+303, .*; scale weights or costs"):
        Problem([[0.0], [1.0]], [0, 1], depth=1, weights=[weight, weight], loss=ClassCosts([[0, cost], [cost, 0]]))


@pytest.mark.parametrize(
    ("solver", "split"), [(branch_and_bound, {}), (two_feature_branch_and_bound, {"split": "hyperplane"})]
)
def test_an_objective_whose_rounding_hides_a_split_is_not_called_optimal(solver, split):
    problem = Problem([[2.0], [2.0], [0.0]], [0, 1, 0], depth=1, weights=[1e12, 1e12 + 1, 1e-12], **split)
    solution = solver(problem)
    better = Split(0, 1.0, Leaf(0), Leaf(1))
    assert problem.exact_objective(solution.tree) - problem.exact_objective(better) == Fraction(1e-12)
    assert (solution.stop, solution.is_optimal) == (Stop.NUMERICS, False)


def test_a_tolerance_is_as_wide_as_the_bound_is_away_and_no_sample_is_lighter():
    problem = Problem([[0.0], [1.0]], [0, 1], depth=1, weights=[0.1, 5.0])
    assert closing_tolerance(1.0, 1.5, problem.least_saving) == 0
    assert 1.0 - closing_tolerance(1.0, 0.95, problem.least_saving) <= 0.95
    assert closing_tolerance(1.0, 0.89, problem.least_saving) == -1
