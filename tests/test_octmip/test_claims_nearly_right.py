"""Claims that are wrong by little, or on the side that looks harmless, are refused as well as gross ones."""

import dataclasses
from contextlib import nullcontext
from fractions import Fraction
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from octmip import Leaf, Limits, Problem, Solution, Split, Stop, certify, near_optimal, solve
from octmip.errors import CertificateError, SolverError
from octmip.trees.answer.set_certificate import certify_set
from octmip.trees.near_sets import NearTree, counting
from octmip.trees.near_sets.whole_numbers import whole_problem
from octmip.trees.nodes.tree import Node, ValueLeaf
from octmip.trees.question.losses import SquaredError
from octmip.trees.tradeoff import frontier
from tests.test_octmip.test_near_sets import Claimed, five_values


def claim(tree: Leaf | Split, objective: float, bound: float) -> Solution:
    return Solution(tree, objective, bound, Stop.TIME, 0.0, 1, "exact", "1", 0)


STUMP = Split(0, 1.5, Leaf(0), Leaf(1))


def test_objectives_in_whole_numbers_are_compared_to_the_last_unit() -> None:
    heavy = 2.0**49
    problem = five_values(weights=[heavy, heavy, 1, heavy, 1])
    certify(problem, claim(STUMP, heavy, 0.0))
    for objective in (heavy - 1, heavy + 1):
        with pytest.raises(CertificateError, match="the tree's own"):
            certify(problem, claim(STUMP, objective, 0.0))


def test_a_listed_tree_is_held_to_its_last_digits() -> None:
    third = 1 / 3
    problem = five_values(weights=np.full(5, third))
    true = near_optimal(problem, within=third)
    listed = NearTree(Leaf(0), problem.objective(Leaf(0)))
    exact = 2 * Fraction(third)
    certify_set(problem, true, [listed])
    just_below = exact - Fraction(1, 2**200)
    assert float(just_below) == float(exact)
    with pytest.raises(CertificateError, match="above the limit"):
        certify_set(problem, Claimed(true, limit=just_below), [listed])  # type: ignore[arg-type]
    with pytest.raises(CertificateError, match="a listed tree claims"):
        certify_set(problem, true, [dataclasses.replace(listed, objective=listed.objective * (1 + 1e-6))])


def unfinished() -> Problem:
    rng = np.random.default_rng(0)
    return Problem(rng.normal(size=(60, 4)), rng.integers(0, 3, 60), depth=3)


def test_a_count_without_an_end_takes_only_an_exact_proof_for_the_optimum() -> None:
    problem = unfinished()
    proven = solve(problem)
    known = near_optimal(problem, within=0, limits=Limits(seconds=0.0), incumbent=proven)
    assert (known.trees, known.optimum) == (None, Fraction(proven.objective))
    nearly = dataclasses.replace(proven, bound=proven.objective - 0.5, tolerance=0.5)
    assert nearly.is_optimal
    found = near_optimal(problem, within=0, limits=Limits(seconds=0.0), incumbent=nearly)
    assert (found.trees, found.optimum, found.limit) == (None, None, None)


def test_a_count_without_a_proof_claims_no_tree_that_the_set_may_lack(monkeypatch: pytest.MonkeyPatch) -> None:
    problem = unfinished()
    leaf = Leaf(int(problem.class_costs().argmin()))
    poor = claim(leaf, problem.baseline, 0.0)
    monkeypatch.setattr(counting, "solve", lambda *_args, **_options: poor)
    found = near_optimal(problem, within=0, limits=Limits(seconds=0.0))
    assert found.trees is None
    assert found.trees_at_least == 0
    assert found.spectrum == ()


def test_a_count_that_left_one_cut_out_claims_no_whole_set(monkeypatch: pytest.MonkeyPatch) -> None:
    """Every feature was begun with, and the last cut that may belong was not counted."""
    problem = five_values()
    true = near_optimal(problem, within=1)

    def cut_short(problem: Problem, tree: Node, by_sets: bool) -> object:
        whole = whole_problem(problem, tree, by_sets)

        def count(limit: int, limits: Limits, n_threads: int, progress: None) -> object:
            found = whole.native.count(limit, limits, n_threads, progress)
            assert not found.open
            cuts = [*found.cuts[:-1], {**found.cuts[-1], "trees": None}]
            return SimpleNamespace(leaves=found.leaves, cuts=cuts, open=[], stop=Stop.TIME, n_nodes=found.n_nodes)

        return dataclasses.replace(whole, native=SimpleNamespace(count=count))

    monkeypatch.setattr(counting, "whole_problem", cut_short)
    found = near_optimal(problem, within=1)
    assert (found.trees, found.stop, len(found.open)) == (None, Stop.TIME, 1)
    assert true.trees is not None
    assert found.trees_at_least < true.trees


def test_counts_that_may_have_overflown_are_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(counting, "UNCOUNTABLE", 5)
    with pytest.raises(SolverError, match="too many to count"):
        near_optimal(five_values(), within=1)


def priced() -> Problem:
    """Return a problem whose trees cost 10 (a|b), 13 (a, b) and 36 (b|a)."""
    return Problem([[0.0], [1.0]], ["a", "b"], depth=1, leaf_penalty=10.0, weights=[13.0, 13.0])


def test_a_share_is_the_decimal_that_it_is_written_as() -> None:
    assert Fraction(0.3) < Fraction(3, 10)
    assert near_optimal(priced(), relative=0.3).trees == 3
    assert near_optimal(priced(), relative=0.2999999).trees == 1


def test_trees_that_cost_more_than_all_errors_together_are_counted_too() -> None:
    assert near_optimal(priced(), within=25.0).trees == 3
    assert near_optimal(priced(), within=26.0).trees == 4


def test_a_set_of_leaves_alone_reads_no_sensor_for_certain() -> None:
    found = near_optimal(five_values(leaf_penalty=5.0), within=0)
    assert (found.trees, found.by_sensors) == (1, {(): 1})


def test_a_bound_of_numbers_above_the_best_leaf_is_refused_although_the_tree_costs_more() -> None:
    problem = Problem([[0.0], [1.0]], [0.0, 2.0], depth=1, loss=SquaredError())
    worse = Split(0, 0.5, ValueLeaf(2.0), ValueLeaf(0.0))
    assert certify(problem, claim(worse, 8.0, 2.0)).objective == 8.0
    with pytest.raises(CertificateError, match=r"one leaf alone costs 2\.0"):
        certify(problem, claim(worse, 8.0, 3.0))


def test_bounds_of_a_larger_penalty_say_nothing_of_a_smaller_one(monkeypatch: pytest.MonkeyPatch) -> None:
    answers = iter([claim(Leaf(0), 2.0, 0.0), claim(Leaf(0), 2.0, 2.0)])
    monkeypatch.setattr(frontier, "solve_run", lambda *_args, **_options: next(answers))
    points = frontier.trace_frontier(five_values(), "penalty", [0.0, 5.0])
    assert [point.solution.bound for point in points] == [0.0, 2.0]


@pytest.mark.parametrize(
    ("options", "off", "is_refused"),
    [
        ({"loss": SquaredError()}, 2.0**-51, True),
        ({"loss": SquaredError()}, 0.0, False),
        ({"weights": [0.1, 0.7, 0.3, 0.9]}, 1e-13, False),
        ({"weights": [0.1, 0.7, 0.3, 0.9]}, 1e-11, True),
        ({}, 2.0**-51, True),
    ],
)
def test_only_sums_of_real_weights_may_be_off_by_a_few_digits(options: Any, off: float, is_refused: bool) -> None:
    problem = Problem(np.zeros((4, 1)), [0, 1, 1, 4] if "loss" in options else [0, 1, 1, 0], depth=1, **options)
    found = solve(problem, "cart")
    claimed = dataclasses.replace(found, objective=found.objective * (1 + off))
    with pytest.raises(CertificateError, match="claims objective") if is_refused else nullcontext():
        certify(problem, claimed)
