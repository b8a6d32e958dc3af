"""CART as a Solution: scikit-learn's tree, judged by the objective of the Problem."""

import math
from itertools import count

import numpy as np
import pytest
from sklearn.datasets import load_iris, load_wine
from sklearn.tree import DecisionTreeClassifier, DecisionTreeRegressor

from octmip import (
    AbsoluteError,
    ClassCosts,
    Leaf,
    Limits,
    Problem,
    Solution,
    Split,
    SquaredError,
    Stop,
    certify,
    predict,
    solve,
)
from octmip.trees.methods import cart
from octmip.trees.methods.cart import greedy_tree
from octmip.trees.nodes.tree import depth, features_used, leaf_index, n_splits


def random_problem(seed: int, **settings: object) -> Problem:
    rng = np.random.default_rng(seed)
    features = np.round(rng.normal(size=(60, 4)), 1)
    labels = (features[:, 0] + rng.normal(0, 0.7, 60) > 0).astype(int) + (features[:, 1] > 0.5)
    return Problem(features, labels, depth=3, **settings)


@pytest.mark.parametrize("load", [load_iris, load_wine])
@pytest.mark.parametrize("depth", [1, 2, 3, 4])
def test_objective_and_predictions_are_those_of_scikit_learns_own_tree(load, depth):
    features, labels = load(return_X_y=True)
    own = DecisionTreeClassifier(max_depth=depth, random_state=0).fit(features, labels)
    solution = greedy_tree(Problem(features, labels, depth=depth))
    assert solution.objective == (own.predict(features) != labels).sum()
    assert (predict(solution.tree, features) == own.predict(features)).all()


def test_a_column_that_float32_cannot_tell_apart_is_separated():
    column = 900 + 1e-6 * np.arange(40)
    problem = Problem(column[:, None], np.arange(40) >= 17, depth=1)
    assert greedy_tree(problem).objective == 0


def test_leaves_take_the_label_of_least_cost():
    problem = Problem([[0.0], [0.0], [0.0], [1.0]], [0, 0, 1, 1], depth=1, loss=ClassCosts([[0, 1], [5, 0]]))
    assert greedy_tree(problem).tree == Leaf(1)  # two zeros taken for ones cost 2, one one taken for a zero 5


def test_a_split_that_does_not_pay_its_penalty_is_cut_away():
    features = [[0.0], [1.0], [2.0], [3.0], [4.0], [5.0]]
    labels = [0, 0, 0, 1, 1, 0]
    assert n_splits(greedy_tree(Problem(features, labels, depth=2)).tree) == 2
    tree = greedy_tree(Problem(features, labels, depth=2, leaf_penalty=1.0)).tree
    assert tree == Leaf(0)  # two splits save two errors: no gain, so none is made


def test_a_budget_takes_the_sensor_that_pays_most():
    features = np.array([[i % 2, i % 4, i] for i in range(16)], dtype=float)
    problem = Problem(features, np.arange(16) % 4 >= 2, depth=2, sensor_budget=1)
    tree = greedy_tree(problem).tree
    assert tree is not None
    assert features_used(tree) == (1,)
    assert greedy_tree(problem).objective == 0


def test_out_of_time_in_the_choice_of_sensors_returns_the_tree_so_far():
    problem = random_problem(0, sensor_budget=1.0)
    solution = greedy_tree(problem, limits=Limits(seconds=0))
    assert solution.stop is Stop.TIME
    certify(problem, solution)


def test_thresholds_lie_midway_between_the_samples_of_the_node():
    solution = greedy_tree(Problem([[0.0], [1.0], [4.0], [9.0]], [0, 0, 1, 1], depth=1))
    assert solution.tree == Split(0, 2.5, Leaf(0), Leaf(1))


def test_samples_of_weight_zero_are_routed_and_have_no_say_in_labels():
    problem = Problem([[0.0], [0.0], [1.0], [1.0]], [0, 1, 1, 1], depth=1, weights=[1, 0, 1, 1])
    solution: Solution = greedy_tree(problem)
    assert solution.tree is not None
    assert solution.objective == 0
    assert np.bincount(leaf_index(solution.tree, problem.samples.features)).tolist() == [2, 2]


def test_more_classes_than_scikit_learn_believes_in_raise_no_warning():
    labels = np.arange(24) % 20
    found = solve(Problem(np.arange(24.0)[:, None], labels, depth=1), "cart")
    assert found.objective == 21


@pytest.mark.parametrize("loss", [SquaredError(), AbsoluteError()], ids=lambda loss: loss.name)
def test_of_numbers_it_is_scikit_learns_regressor_pruned_where_splits_do_not_pay(loss):
    rng = np.random.default_rng(5)
    features = rng.normal(size=(80, 3))
    targets = np.round(features[:, 0] * features[:, 1] + rng.normal(0, 0.3, 80), 2)
    problem = Problem(features, targets, depth=3, leaf_size=4, loss=loss)
    found = greedy_tree(problem)
    certify(problem, found)
    grown = DecisionTreeRegressor(max_depth=3, min_samples_leaf=4, random_state=0, criterion=f"{loss.name}_error")
    theirs = grown.fit(features, targets).predict(features)
    assert found.objective == pytest.approx(loss.of_misses(targets - theirs).sum(), rel=1e-6)
    assert greedy_tree(problem.replace(leaf_penalty=1e6)).tree == problem.best_leaf()
    assert solve(problem, "exact").objective <= found.objective


def test_a_limit_of_nodes_is_the_most_splits_and_changes_no_smaller_tree():
    problem = random_problem(4).replace(depth=30)
    whole = greedy_tree(problem)
    size = n_splits(whole.tree)
    assert greedy_tree(problem, limits=Limits(nodes=60)).tree == whole.tree  # 60 samples part in 59 splits at most
    limited = greedy_tree(problem, limits=Limits(nodes=size // 2))
    certify(problem, limited)
    assert 0 < n_splits(limited.tree) <= size // 2
    assert limited.objective >= whole.objective


@pytest.mark.parametrize(("seconds", "levels"), [(0.5, 1), (3.9, 1), (4.5, 2), (99.0, 5), (math.inf, 5)])
def test_a_deadline_leaves_the_levels_that_the_first_one_lets_expect(monkeypatch, seconds, levels):
    rng = np.random.default_rng(0)
    problem = Problem(rng.normal(size=(60, 3)), rng.integers(0, 3, 60), depth=5)
    clock = count()  # each look at it is a second later
    monkeypatch.setattr(cart, "MEASURED_WORK", 0)
    monkeypatch.setattr(cart.time, "perf_counter", lambda: next(clock))
    found = greedy_tree(problem, limits=Limits(seconds=seconds))
    assert (depth(found.tree), found.stop) == (levels, Stop.FINISHED if levels == 5 else Stop.TIME)
