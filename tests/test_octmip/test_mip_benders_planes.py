"""Benders for hyperplanes of few features: the optimum of the exact core, and cores that no split tells apart."""

from itertools import combinations

import numpy as np
import pytest

from octmip import Limits, Problem, Stop, certify, solve
from octmip.errors import ProblemError
from octmip.mip.benders.planes.question import Question, feature_sets
from octmip.mip.benders.planes.search import PlaneSearch
from octmip.mip.benders.planes.separation import Separation
from octmip.mip.benders.solver import solve_benders
from octmip.mip.prices import own_prices
from octmip.tree import Leaf


def grid(seed: int, n: int = 10, p: int = 2, n_classes: int = 2, **options) -> Problem:
    rng = np.random.default_rng(seed)
    features = rng.integers(0, 5, (n, p)).astype(float)
    labels = np.append(np.arange(n_classes), rng.integers(0, n_classes, n - n_classes))
    return Problem(features, labels, **({"depth": 2, "split": "hyperplane", "split_size": 2} | options))


def question_of(problem: Problem, mu: float | None = 1e-4) -> Question:
    return Question.of(problem, own_prices(problem), Leaf(0), mu)


@pytest.mark.parametrize(
    "problem",
    [
        grid(1),
        grid(2, depth=1),
        grid(3, n_classes=3),
        grid(4, p=3, weights=np.arange(1.0, 11.0)),
        grid(5, p=3, allowed_splits=[[0, 1], [2]]),
    ],
)
def test_the_proven_optimum_is_that_of_the_exact_core(problem):
    found = solve_benders(problem, mu=1e-4)
    certify(problem, found)
    assert found.stop is Stop.OPTIMAL
    assert found.objective == found.bound == solve(problem, "exact").objective


def test_whole_coefficients_are_proven_for_all_trees():
    problem = grid(6, integer_normals=1)
    found = solve_benders(problem)
    assert "all trees with whole coefficients up to 1" in found.details["scope"]
    assert found.objective == found.bound == solve(problem, "flow").objective


def test_a_limit_ends_the_run_with_a_tree_and_a_bound_that_holds():
    problem = grid(7, n=24, n_classes=3)
    best = solve(problem, "exact").objective
    for limits, stop in ((Limits(seconds=1e-6), Stop.TIME), (Limits(nodes=1), Stop.NODES)):
        found = solve_benders(problem, limits=limits)
        assert found.stop is stop
        assert found.bound <= best <= found.objective


def test_no_more_masters_are_solved_than_the_limit_of_nodes_allows():
    problem = grid(7, n=24, n_classes=3)
    found = solve_benders(problem, limits=Limits(nodes=3), mu=1e-4)
    assert (found.stop, found.n_nodes) == (Stop.NODES, 3)


def test_a_tree_that_costs_more_than_claimed_ends_the_run_as_numerics(monkeypatch):
    monkeypatch.setattr(PlaneSearch, "cheaper", lambda self, target: Leaf(0))
    found = solve_benders(grid(1), mu=1e-4)
    assert found.stop is Stop.NUMERICS
    assert "when all samples are routed" in found.details["numerics"]
    assert found.bound < found.objective


def test_a_problem_without_a_split_is_its_best_leaf():
    problem = grid(1, allowed_splits=[])
    found = solve_benders(problem, incumbent=Leaf(int(problem.class_costs().argmax())))
    assert (found.stop, found.objective) == (Stop.OPTIMAL, problem.class_costs().min())


def test_no_split_of_any_set_tells_a_core_apart_and_every_smaller_one_is_told_apart():
    problem = grid(8, n=16, p=3)
    question = question_of(problem)
    separation = Separation(question, lambda: None)
    core = separation.core(np.arange(len(question.code)), np.ones(len(question.code), dtype=bool))
    assert core is not None
    part = Problem(
        problem.features[question.sample[core]], problem.labels[question.sample[core]], depth=1, split="hyperplane"
    )
    assert all(
        solve(Problem(part.features[:, pair], part.labels, depth=1, split="hyperplane"), "exact").objective > 0
        for pair in combinations(range(3), 2)
    )
    for point in core:
        assert separation.split(core[core != point]) is not None or len(core) == 2


def test_sets_of_features_hold_no_other_set_and_too_many_are_refused():
    assert feature_sets(grid(0, p=3)) == ((0, 1), (0, 2), (1, 2))
    assert feature_sets(grid(0, p=3, allowed_splits=[[0], [0, 1], [2]])) == ((0, 1), (2,))
    features = np.random.default_rng(0).normal(size=(10, 70))
    with pytest.raises(ProblemError, match="choose 'flow'"):
        feature_sets(Problem(features, np.arange(10) % 2, depth=1, split="hyperplane", split_size=2))


def test_the_cases_hold_every_pair_of_labels_with_the_weight_that_they_leave_out():
    cases = question_of(grid(0, n_classes=3)).cases()
    labels = [case.labels for case in cases]
    assert len(labels) == len(set(labels)) == 6
    assert min(cases.values()) == 0
    assert cases[next(case for case in cases if case.labels == ((0, 1), (0, 1)))] > 0
