"""A scope is said whole: nothing that narrows it is left out of its words, and no tree inside is below the bound."""

import re

import numpy as np
import pytest

from benchmarks.cases.exact.scopes import outcome
from octmip import Leaf, Problem, certify, solve
from octmip.trees.answer.scope import depth_in_words, limits_in_words, scope_of
from octmip.trees.runs.registry import Run
from octmip.trees.tradeoff.family import Family, solve_in_family
from tests.oracles.scopes import PATTERNS, Said, least_inside


def test_no_better_tree_lies_inside_a_scope_that_is_said():
    lines = [outcome(seed) for seed in range(8)]
    assert [line for line in lines if line["fault"]] == []
    assert sum(bool(line["scope"]) for line in lines) > 2


def noisy(seed=1, **asked):
    rng = np.random.default_rng(seed)
    features = rng.normal(size=(30, 2))
    return Problem(features, (features.sum(axis=1) > 0) ^ (rng.random(30) < 0.3), **asked)


@pytest.mark.parametrize(
    ("limit", "seed", "asked"),
    [
        ("depth", 1, {"depth": 1}),
        ("leaf_size", 1, {"depth": 2, "leaf_size": 9}),
        ("splits", 1, {"depth": 2, "max_splits": 1}),
        ("splits", 1, {"depth": None, "max_splits": 1, "leaf_penalty": 0.5}),
        ("budget", 1, {"depth": 2, "sensor_budget": 1.0}),
        ("quantiles", 1, {"depth": 2}),
    ],
)
def test_the_words_name_each_limit_and_without_it_a_better_tree_is_inside(limit, seed, asked):
    problem = noisy(seed, **asked)
    solution = solve(problem, "exact")
    if limit == "quantiles":
        solution = solve_in_family(problem, Family(2, "exact", 5), Run(), Leaf(0))
    words = scope_of(problem, solution)
    assert certify(problem, solution).scope == words
    cuts = solution.details.get("cuts", ())
    assert least_inside(problem, words, cuts) == solution.bound == solution.objective
    weaker = "of depth 5 or less" if limit == "depth" else ""
    assert least_inside(problem, re.sub(PATTERNS[limit], weaker, words)) < solution.bound


@pytest.mark.parametrize(
    ("asked", "words"),
    [
        ({"leaf_size": 1}, ""),
        ({"leaf_size": 2}, ", with 2 samples or more in each leaf"),
        ({"max_splits": 1}, ", with at most 1 split"),
        ({"max_splits": 2}, ", with at most 2 splits"),
        ({"sensor_budget": 0.5}, ", with sensors that cost 0.5 or less"),
        (
            {"split": "hyperplane", "split_size": 2, "max_splits": 3},
            ", with up to 2 features in a split, with at most 3 features in all splits",
        ),
        ({"old_tree": Leaf(0), "max_changes": 2}, ", with at most 2 changes of the old tree"),
        ({"old_tree": Leaf(0), "max_changes": 1}, ", with at most 1 change of the old tree"),
    ],
)
def test_a_limit_is_said_from_the_first_value_on_that_limits(asked, words):
    assert limits_in_words(noisy(depth=2, **asked)) == f"of depth 2 or less{words}"


def test_limits_that_enumeration_does_not_know_are_named_too():
    problem = noisy(depth=2, leaf_weight=3.0, monotone={0: 1}, class_order=[False, True])
    assert scope_of(problem, solve(problem, "exact")).endswith(
        "with a weight of 3 or more in each leaf, in the order asked for"
    )
    lines = noisy(depth=1, split="hyperplane", split_size=2).replace(allowed_splits=[[0, 1]], integer_normals=3)
    words = scope_of(lines, solve(lines, "cart"))
    assert words.startswith(
        "trees of depth 1 or less, with up to 2 features in a split, with whole coefficients up to 3"
    )
    assert words.endswith("of the allowed groups of features")
    deeper = Problem([[float(k)] for k in (*range(40), 0, 0, 0)], [0] * 40 + [1] * 3, depth=None, leaf_penalty=0.001)
    assert scope_of(deeper, solve(deeper, "exact")) == "trees of depth 30 or less"
    assert depth_in_words(None) == "of any depth"
    with pytest.raises(ValueError, match="names no depth"):
        Said.read("trees that cut each feature at 5 quantiles at most")


def test_the_best_of_separated_trees_is_not_called_the_best_of_all():
    rng = np.random.default_rng(7)
    problem = Problem(rng.normal(size=(20, 4)), rng.integers(0, 2, 20), depth=1, split="hyperplane")
    separated, better = solve(problem, "oct_h"), solve(problem, "search")
    assert better.objective < separated.objective == separated.bound
    assert separated.meets_bound
    assert not separated.is_optimal
    assert separated.scope.startswith("mu-separated trees")
    assert f"proven optimal among {separated.scope}" in str(separated)
    certify(problem, separated)
