"""Ranks and whole costs: the way to the native core loses nothing that a proof rests on, and the way back is exact."""

import itertools
import pickle
from fractions import Fraction
from operator import le

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from octmip import ClassCosts, Leaf, Problem, Split, predict, solve
from octmip.trees.encoding import costs as grid
from octmip.trees.encoding import integer_costs, rank_features, rows_from_tree, tree_from_rows
from octmip.trees.nodes.reached import without_empty_sides
from tests.oracles.strategies import problems, random_problem, random_tree
from tests.oracles.wide_problems import wide_problem


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
    problem = Problem([[0.0], [1.0], [2.0]], [0, 1, 0], depth=2, **settings)
    costs = integer_costs(problem)
    most = sum(int(w) * int(costs.costs[row].max()) for w, row in zip(costs.weights, costs.rows, strict=True))
    assert 0 < most + costs.penalty < 2**61
    best = int(problem.class_costs().argmin())
    held = costs.value(costs.whole_objective(problem, Leaf(best)))
    assert 0 <= problem.baseline - held <= costs.tolerance + 1e-15 * problem.baseline


X, Y = np.arange(6.0)[:, None], [0, 1, 0, 1, 1, 0]


@pytest.mark.parametrize(
    ("options", "unit"),
    [
        ({}, 1.0),
        ({"weights": [0.5, 1, 2.25, 3, 1, 1]}, 0.25),
        ({"weights": [0.5, 1, 2, 3, 1, 1], "loss": ClassCosts([[0, 0.25], [1, 0]])}, 0.125),
        ({"leaf_penalty": 0.375}, 0.125),
        ({"weights": [1e9] * 6}, 1.0),
    ],
)
def test_dyadic_numbers_are_whole_in_the_largest_unit(options, unit):
    costs = integer_costs(Problem(X, Y, depth=1, **options))
    assert (costs.unit, costs.tolerance) == (unit, 0.0)


@pytest.mark.parametrize("most_own_rows", [0, 64])
def test_no_cost_on_the_grid_is_above_the_true_one_in_exact_arithmetic(most_own_rows, monkeypatch):
    monkeypatch.setattr(grid, "MOST_OWN_ROWS", most_own_rows)
    for seed in range(50):
        for problem in (
            random_problem(np.random.default_rng([3, seed])),
            wide_problem(np.random.default_rng([4, seed])),
        ):
            costs = integer_costs(problem)
            unit = Fraction(2) ** -costs.exponent
            for row, weight, label, true in zip(
                costs.rows, costs.weights, problem.samples.codes, problem.samples.weights, strict=True
            ):
                prices = [Fraction(price) for price in problem.costs[label].tolist()]
                base = min(prices) if costs.is_rounded else 0
                held = [int(weight) * int(costs.costs[row, k]) * unit for k in range(problem.samples.n_classes)]
                exact = [Fraction(float(true)) * (price - base) for price in prices]
                assert all(map(le, held, exact)), f"seed {seed}"
                assert costs.is_rounded or held == exact, f"seed {seed}"


def test_many_real_weights_and_real_costs_are_told_apart_to_a_millionth_of_the_worst():
    rng = np.random.default_rng(0)
    problem = Problem(
        rng.random((2000, 1)),
        np.arange(2000) % 3,
        depth=1,
        weights=rng.random(2000),
        loss=ClassCosts(rng.random((3, 3))),
    )
    assert integer_costs(problem).tolerance < 1e-6 * problem.samples.weights.sum()


def test_a_sample_that_no_tree_gives_up_takes_no_digits_from_the_others():
    """Weights over 24 orders: the heavy sample is cut to just above the best leaf, and nothing is lost."""
    problem = Problem(X, Y, depth=1, weights=[1e12, 1.0, 1.5, 1e-6, 1e-12, 2e-12])
    costs = integer_costs(problem)
    assert costs.tolerance < 1e-15


def test_the_cheaper_the_tree_known_the_finer_the_grid():
    problem = Problem(X, Y, depth=2, weights=10.0 ** np.linspace(-9, 9, 6))
    tree = Split(0, 4.5, Leaf(1), Leaf(0))
    known = integer_costs(problem, tree)
    assert problem.objective(tree) < 1e-3 * problem.baseline
    assert known.exponent > integer_costs(problem).exponent + 9


def test_what_no_prediction_avoids_is_counted_apart():
    problem = Problem(X, Y, depth=1, loss=ClassCosts([[1e15, 1e15 + 1], [0.1, 1e12]]), weights=[1, 1, 1, 1, 1, 0.1])
    costs = integer_costs(problem)
    cheapest = problem.costs.min(axis=1)[problem.samples.codes]
    exact = sum(Fraction(w) * Fraction(c) for w, c in zip(problem.samples.weights, cheapest, strict=True))
    assert costs.base == exact
    assert costs.value(0) <= exact


def lossy(seed: int, kind: str) -> Problem:
    """Return a problem whose costs span more digits than the grid has, rounded in one of its three ways."""
    rng = np.random.default_rng(seed)
    n = 12
    features, labels = np.arange(float(n))[:, None], np.arange(n) % 3
    weights = 10.0 ** rng.uniform(-6, 6, n)
    if kind == "one price":
        return Problem(features, labels, depth=1, weights=weights)
    costs = 10.0 ** rng.uniform(-6, 0, (3, 3)) * (1 - np.eye(3))
    return Problem(features, labels, depth=1, weights=weights, loss=ClassCosts(costs))


@pytest.mark.parametrize(("kind", "most_own_rows"), [("one price", 64), ("rows of their own", 64), ("products", 0)])
def test_the_tolerance_covers_what_rounding_takes_from_a_tree_no_worse_than_the_known(kind, most_own_rows, monkeypatch):
    monkeypatch.setattr(grid, "MOST_OWN_ROWS", most_own_rows)
    n_rounded = 0
    for seed in range(40):
        problem = lossy(seed, kind)
        costs = integer_costs(problem)
        known = min(problem.exact_objective(Leaf(label)) for label in range(3))
        for cut in range(problem.samples.n_samples - 1):
            for left, right in itertools.product(range(3), repeat=2):
                tree = Split(0, cut + 0.5, Leaf(left), Leaf(right))
                exact = problem.exact_objective(tree)
                if exact <= known:
                    held = costs.base + costs.whole_objective(problem, tree) * Fraction(2) ** -costs.exponent
                    n_rounded += held < exact
                    assert held <= exact <= held + Fraction(costs.tolerance), f"seed {seed}"
    assert n_rounded > 100


def test_a_penalty_that_no_tree_pays_takes_no_digits():
    """No answer costs more than another, so every split is a loss; the penalty has 59 digits of its own."""
    costs, weights = [[1, 1], [1e-6, 0]], [1, 1, 1, 0]
    problem = Problem(
        [[0], [1], [2], [3]], [0, 0, 0, 1], depth=1, weights=weights, loss=ClassCosts(costs), leaf_penalty=0.008
    )
    solution = solve(problem)
    assert (solution.objective, solution.bound) == (3, 3)
    assert isinstance(solution.tree, Leaf)
    for size in (1e-300, 1e-30, 1e-3, 1e3, 1e30, 1e300):
        assert solve(problem.replace(leaf_penalty=size)).is_optimal


def lost(problem: Problem, tree: Leaf | Split) -> Fraction:
    """Return what a tree costs beyond what the grid says."""
    costs = integer_costs(problem)
    return problem.exact_objective(tree) - costs.base - costs.whole_objective(problem, tree) * Fraction(costs.unit)


def test_the_tolerance_covers_what_rounding_takes_from_the_price_of_each_split():
    """Two samples and three splits lose almost a unit each: more units than there are samples."""
    unit = 2.0**-58
    almost = unit * (1 - 2.0**-10)
    weights = [1.0, 1.0, 2.0**-25 + almost, 2.0**-25 + almost]
    problem = Problem(X[:4], [0, 1, 2, 3], depth=2, weights=weights, leaf_penalty=2.0**-26 + almost)
    tree = Split(0, 1.5, Split(0, 0.5, Leaf(0), Leaf(1)), Split(0, 2.5, Leaf(0), Leaf(0)))
    costs = integer_costs(problem)
    assert (costs.unit, problem.exact_objective(tree) < problem.baseline) == (unit, True)
    assert 4 * unit < lost(problem, tree) <= costs.tolerance


def test_what_multiples_of_a_tenth_lose_is_in_the_tolerance_although_the_grid_holds_them():
    problem = Problem(X[:3], [0, 0, 1], depth=1, weights=[0.1, 0.3, 0.7])
    assert 0 < lost(problem, Leaf(1)) <= integer_costs(problem).tolerance


def test_a_cost_that_is_lowered_stays_above_the_tree_that_is_known():
    problem = Problem(X[:3], [0, 0, 1], depth=1, weights=[0.1, 0.2, 0.7])
    costs = integer_costs(problem)
    known, dear = (costs.whole_objective(problem, Leaf(label)) for label in (1, 0))
    assert known < dear < 7 * known // 3


@pytest.mark.parametrize("price", [0.32, 0.4])
def test_a_cost_between_the_known_tree_and_the_next_multiple_is_not_rounded_down_to_the_tree(price):
    """Two wrong answers cost 0.3 together, and one costs 0.32 or 0.4: in steps of 0.15 that is 0.3 as well."""
    problem = Problem(X[:3], [1, 0, 0], depth=1, loss=ClassCosts([[0, 0.15], [price, 0]]))
    costs = integer_costs(problem)
    known, dear = (costs.whole_objective(problem, Leaf(label)) for label in (1, 0))
    assert known < dear
    assert costs.tolerance < 1e-12
