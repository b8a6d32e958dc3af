"""Two-feature trees of depth 3: bounded by those of depth 2."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from octmip import ClassCosts, Limits, Problem, Progress, Stop, certify
from octmip.errors import ProblemError
from octmip.trees.methods.exact import branch_and_bound
from octmip.trees.methods.options import ExactOptions
from octmip.trees.methods.two_feature import _one_level_deeper, two_feature_branch_and_bound
from tests.oracles.rational import least_cost
from tests.oracles.two_feature_problems import random_two_feature_problem


def mixed(depth: int) -> Problem:
    """Return a problem of three classes, four samples each, that no split tells apart, and one pair that one does."""
    features = [[0, 0]] * 12 + [[1, 0], [0, 1]]
    return Problem(features, [0, 1, 2] * 4 + [0, 1], depth=depth, split="hyperplane", split_size=2)


def test_a_bound_of_depth_three_is_never_above_the_optimum_of_enumeration() -> None:
    n_positive = 0
    for seed in range(80):
        rng = np.random.default_rng([3, seed])
        problem = random_two_feature_problem(rng, depth=3, max_samples=7)
        # Few different points: where lines part all samples, the optimum is 0 and so is every bound.
        problem = replace(problem, features=problem.features[rng.integers(0, 2, problem.n_samples)])
        solution = two_feature_branch_and_bound(problem)
        certify(problem, solution)
        optimum = float(least_cost(problem))
        assert solution.bound <= optimum <= solution.objective, f"seed {seed}"
        n_positive += solution.bound > 0
    assert n_positive >= 5


def test_the_bound_is_twice_that_of_depth_two_less_what_all_samples_cost() -> None:
    shallower = two_feature_branch_and_bound(mixed(2))
    solution = two_feature_branch_and_bound(mixed(3))
    assert (shallower.objective, shallower.stop) == (8, Stop.OPTIMAL)
    assert (solution.objective, solution.bound, solution.stop) == (8, 2 * 8 - 14, Stop.FINISHED)
    assert solution.details["bound"] == "from the trees of one level fewer"


def test_a_known_tree_of_depth_three_is_kept_and_a_perfect_one_is_proven() -> None:
    features, labels = [[k, k % 2] for k in range(8)], [0, 1, 2, 3, 0, 1, 2, 3]
    problem = Problem(features, labels, depth=3, split="hyperplane", split_size=2)
    seen: list[Progress] = []
    known = two_feature_branch_and_bound(problem, progress=seen.append)
    assert known.objective > 0
    assert all(state.bound <= known.objective for state in seen)
    from_axis = two_feature_branch_and_bound(
        problem, incumbent=branch_and_bound(Problem(features, labels, depth=3)).tree
    )
    assert (from_axis.objective, from_axis.bound, from_axis.stop) == (0, 0, Stop.OPTIMAL)


def test_a_limit_is_handed_down_and_logs_are_refused(tmp_path: Path) -> None:
    rng = np.random.default_rng(0)
    problem = Problem(rng.normal(size=(200, 4)), rng.integers(0, 5, 200), depth=3, split="hyperplane", split_size=2)
    seen: list[Progress] = []
    assert two_feature_branch_and_bound(problem, limits=Limits(nodes=200), progress=seen.append).stop == Stop.NODES
    assert seen
    assert all(state.bound <= state.objective <= problem.baseline for state in seen)
    with pytest.raises(ProblemError, match="end at depth 2"):
        two_feature_branch_and_bound(problem, options=ExactOptions(proof=tmp_path / "file"))


def test_products_that_only_look_whole_are_taken_as_rounded() -> None:
    costs = np.full((2, 2), 10.0) - 10.0 * np.eye(2)
    problem = Problem(
        [[0.0, 1.0], [1.0, 0.0], [2.0, 2.0]],
        [0, 1, 0],
        depth=3,
        split="hyperplane",
        split_size=2,
        weights=[0.1, 0.1, 0.1],  # times 10 is 1.0 as float64, and a little more in truth
        loss=ClassCosts(costs),
    )
    assert 0.999 < _one_level_deeper(problem, 2.0) < 1.0
