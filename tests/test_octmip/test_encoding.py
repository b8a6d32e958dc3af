"""Ranks and whole costs: the way to the native core loses nothing that a proof rests on, and the way back is exact."""

import pickle

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from octmip import ClassCosts, Leaf, Problem, Split, predict
from octmip.trees.encoding import integer_costs, rank_features, rows_from_tree, tree_from_rows
from octmip.trees.nodes.digits import midpoint
from octmip.trees.nodes.reached import without_empty_sides
from tests.oracles.strategies import problems, random_tree


def with_costs(**settings):
    return Problem([[0.0], [1.0], [2.0]], [0, 1, 0], depth=2, **settings)


def test_ranks_of_rows_are_taken_by_the_core_and_survive_a_journey():
    table = rank_features(Problem([[0.5, 1], [0.5, 0], [1.5, 0], [4.0, 0]], [0, 1, 0, 1], depth=1)).table
    taken = table.of_rows(np.array([3, 0]))
    assert taken.array().tolist() == [[2, 0], [0, 1]]
    assert pickle.loads(pickle.dumps(taken)).array().tolist() == taken.array().tolist()
    assert taken.column(1).tolist() == [0, 1]
    with pytest.raises(IndexError, match="row 4 of 4"):
        table.of_rows(np.array([4]))
    with pytest.raises(IndexError, match="feature 2 of 2"):
        table.column(2)


def test_a_cut_comes_back_as_the_midpoint_of_its_neighbours():
    ranks = rank_features(Problem([[0.5], [1.5], [4.0]], [0, 1, 0], depth=1))
    rows = [{"feature": 0, "cut": 1, "left": 1, "right": 2}, {"label": 1}, {"label": 0}]
    assert tree_from_rows(rows, ranks) == Split(0, 2.75, Leaf(1), Leaf(0))


@given(problems(max_samples=12), st.integers(0, 2**32 - 1))
def test_a_tree_passes_the_border_and_back_with_the_same_predictions(problem, seed):
    tree = random_tree(np.random.default_rng(seed), problem.samples.n_features, problem.samples.n_classes, 3)
    tree = without_empty_sides(tree, problem.samples.features)
    ranks = rank_features(problem)
    back = tree_from_rows(rows_from_tree(tree, ranks), ranks)
    assert (predict(back, problem.samples.features) == predict(tree, problem.samples.features)).all()


@pytest.mark.parametrize(
    "settings",
    [
        {"weights": [0.1, 0.2, 0.3]},
        {"loss": ClassCosts([[0, 1 / 3], [1, 0]])},
        {"leaf_penalty": 1e-9},
        {"leaf_penalty": 1e30},
        {"weights": [1e12, 1e12, 3e12], "loss": ClassCosts([[0, 1e8], [1e8, 0]])},
        {"weights": [1e12, 1e12, 3e12], "loss": ClassCosts([[0, 0.1], [0.1, 0]])},
        {"weights": [2.0**40, 1, 1], "loss": ClassCosts([[0, 2.0**-30], [1, 0]])},
        {"weights": [1e300, 1e-300, 1e300]},
        {"weights": [0.1, 0.2, 0.3], "loss": ClassCosts([[0, 1 / 3], [1, 0]]), "leaf_penalty": 0.1},
    ],
)
def test_no_objective_overflows_whatever_the_numbers(settings):
    problem = with_costs(**settings)
    costs = integer_costs(problem)
    most = sum(int(w) * int(costs.costs[row].max()) for w, row in zip(costs.weights, costs.rows, strict=True))
    assert 0 < most + costs.penalty < 2**61
    best = int(problem.class_costs().argmin())
    held = costs.value(costs.whole_objective(problem, Leaf(best)))
    assert 0 <= problem.baseline - held <= costs.tolerance + 1e-15 * problem.baseline


def test_a_threshold_between_neighbouring_floats_sends_the_upper_one_right():
    low = 1.0
    high = np.nextafter(low, 2)
    assert low <= midpoint(low, high) < high
    assert midpoint(-1e308, 1e308) == 0.0
    assert midpoint(1e308, 1.5e308) < 1.5e308
