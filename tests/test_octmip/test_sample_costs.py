"""Costs of single samples: one row of costs each, for exact, search, CART and the models."""

import math
from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest

import octmip
from benchmarks.kinds.sample_costs import sample_problem
from benchmarks.outside import BY_PYOMO
from octmip import ClassCosts, Leaf, Problem, Split, certify
from octmip.errors import ProblemError
from octmip.formats.tree_file import read_tree_file, record_tree, write_tree_file
from octmip.trees.answer.solution import Stop
from octmip.trees.encoding.sample_costs import weighted_rows
from octmip.trees.question.losses import loss_of
from octmip.trees.question.problem_file import write_problem_file

COSTS = [[0.0, 3.0, 1.0], [5.0, 0.0, 1.0], [2.0, 2.0, 1.0], [0.0, 9.0, 4.0]]


def small(**options: object) -> Problem:
    """Return four samples in a row and three decisions: wait, repair, inspect."""
    decisions = ("wait", "repair", "inspect")
    wanted = ["wait", "repair", "inspect", "wait"]
    given = {"depth": 1, "class_names": decisions, "loss": ClassCosts(COSTS, per_sample=True)} | options
    return Problem([[0.0], [1.0], [2.0], [3.0]], wanted, **given)


def test_a_tree_costs_the_sum_of_its_samples_own_costs():
    tree = Split(0, 0.5, Leaf(0), Leaf(2))
    assert small().objective(tree) == 0 + 1 + 1 + 4
    assert small().exact_objective(tree) == 6
    assert small(weights=[1, 2, 1, 0.5]).objective(tree) == 0 + 2 + 1 + 2
    assert small().baseline == min(0 + 5 + 2 + 0, 3 + 0 + 2 + 9, 1 + 1 + 1 + 4)


def test_weighted_rows_cost_every_tree_the_same_but_for_the_base():
    for seed in range(40):
        problem = sample_problem(np.random.default_rng(seed))
        made = weighted_rows(problem)
        for label in range(problem.samples.n_classes):
            tree = Split(0, 2.5, Leaf(label), Leaf(0))
            more = problem.exact_objective(tree) - made.rows.exact_objective(tree) - made.base
            assert 0 <= more <= made.spread


@pytest.mark.parametrize("share", [0.0, 0.5, 1.0])
def test_a_bound_over_the_rows_is_one_of_the_problem_less_the_base(share):
    for seed in range(40):
        problem = sample_problem(np.random.default_rng(seed))
        made = weighted_rows(problem)
        found = replace(octmip.solve(made.rows, "exact"), stop=Stop.NODES)
        back = made.back(replace(found, bound=share * found.bound))
        true = max(Fraction(share * found.bound) + made.base, Fraction(0))
        assert (
            Fraction(back.bound) == min(math.ceil(true), back.objective)
            if problem.has_integer_costs
            else (true * (1 - Fraction(1, 10**14)) <= Fraction(back.bound) <= true)
        )


def test_costs_by_class_are_the_special_case_of_equal_rows():
    rng = np.random.default_rng(3)
    features, targets = rng.integers(0, 9, (40, 2)).astype(float), rng.integers(0, 3, 40)
    matrix = np.array([[0.0, 1.0, 5.0], [2.0, 0.0, 1.0], [4.0, 4.0, 0.0]])
    by_class = Problem(features, targets, depth=2, loss=ClassCosts(matrix))
    by_sample = Problem(features, targets, depth=2, loss=ClassCosts(matrix[targets], per_sample=True))
    found = [octmip.solve(problem, "exact") for problem in (by_class, by_sample)]
    assert found[0].objective == found[1].objective == found[1].bound
    assert by_class.least_saving == by_sample.least_saving


@pytest.mark.parametrize(("leaf_size", "least"), [(1, 3), (2, 4)])
def test_a_solved_model_of_them_is_read(leaf_size, least):
    model = octmip.model(small(leaf_size=leaf_size), "oct")
    solution = octmip.solution_of(model, BY_PYOMO["HiGHS"](model, 10.0))
    assert (solution.objective, solution.bound) == (least, least)


def test_a_decision_that_is_nobodys_best_is_no_error():
    problem = Problem(
        [[0.0], [1.0]], ["a", "a"], depth=1, class_names=("a", "b"), loss=ClassCosts([[1, 0], [0, 3]], per_sample=True)
    )
    assert octmip.solve(problem, "exact").objective == 0
    same = Problem(
        [[0.0], [1.0]], [0, 0], depth=1, class_names=(0, 1), loss=ClassCosts([[2, 2], [1, 1]], per_sample=True)
    )
    solution = octmip.solve(same, "exact")
    assert (solution.objective, solution.is_optimal, solution.tree) == (3, True, Leaf(0))


def test_a_tree_file_holds_the_costs_and_certifies_them(tmp_path):
    problem = small()
    solution = octmip.solve(problem, "exact")
    write_tree_file(tmp_path / "t.json", record_tree(problem, solution))
    file = read_tree_file(tmp_path / "t.json")
    assert file.solution.objective == solution.objective
    loss = loss_of(problem.loss.to_json())
    assert np.array_equal(loss.table, COSTS)
    assert certify(small(loss=loss), file.solution).objective == solution.objective


@pytest.mark.parametrize(
    ("ask", "said"),
    [
        (lambda: small(loss=ClassCosts(COSTS[:3], per_sample=True)), "a row for each sample"),
        (lambda: small(loss=ClassCosts(per_sample=True)), "costs are left out"),
        (lambda: small(loss=ClassCosts(COSTS)), "rows and columns"),
        (lambda: octmip.solve(small(leaf_size=2), "exact"), "leaf_size 1 or two decisions"),
        (lambda: octmip.solve(small(), "exact", options=octmip.ExactOptions(proof="p.log")), "leave proof out"),
        (lambda: write_problem_file("p.json", small()), "costs of classes"),
        (lambda: octmip.near_optimal(small(), 0.1), "costs of classes"),
        (lambda: small().loss.row_costs(np.ones(1), np.array([0]), np.array([1])), "costs of classes"),
    ],
)
def test_what_costs_of_samples_cannot_do_is_said(ask, said):
    with pytest.raises(ProblemError, match=said):
        ask()


def test_a_least_leaf_size_is_kept_with_two_decisions_and_in_the_model():
    problem = Problem(
        [[0.0], [1.0], [2.0]], [0, 1, 1], depth=1, leaf_size=2, loss=ClassCosts([[0, 9], [1, 0], [1, 0]], True)
    )
    assert octmip.solve(problem, "exact").tree == Leaf(0)
    assert Fraction(2) == problem.exact_objective(Leaf(0))
