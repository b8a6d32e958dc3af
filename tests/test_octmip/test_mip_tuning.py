"""Tuning over depth and number of splits, and trees handed to HiGHS while it runs."""

import math
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from octmip import Leaf, Limits, Problem, Split
from octmip.errors import ProblemError
from octmip.mip.engine import objective_of
from octmip.mip.feed import Feed
from octmip.mip.oct import solve_oct
from octmip.mip.tuning import tune
from octmip.tree import complexity
from tests.oracles.enumeration import optimum
from tests.test_octmip.test_mip import blobs, stop_at_six, uci


@pytest.mark.parametrize("method", ["flow", "oct"])
def test_each_candidate_is_the_optimum_at_the_middle_of_its_penalties(method):
    problem = blobs(depth=2, weights=[1, 9, 2, 1, 1, 5, 9, 1, 3, 1, 2, 6])
    tuning = tune(problem, method=method)
    assert len(tuning.candidates) >= 3
    for candidate in tuning.candidates:
        high = candidate.penalty_high if math.isfinite(candidate.penalty_high) else candidate.penalty_low + 5
        penalty = (candidate.penalty_low + high) / 2
        assert candidate.cost + penalty * candidate.complexity == pytest.approx(
            optimum(replace(problem, leaf_penalty=penalty)).objective
        )
        assert candidate.cost == objective_of(problem, candidate.tree)
        assert candidate.complexity == complexity(candidate.tree) and candidate.is_proven


def test_intervals_of_penalties_meet_and_costs_rise_as_trees_shrink():
    candidates = tune(blobs(depth=2)).candidates
    for larger, smaller in pairwise(candidates):
        assert larger.penalty_high == smaller.penalty_low
        assert larger.complexity > smaller.complexity and larger.cost < smaller.cost
    assert candidates[0].penalty_low == 0 and candidates[-1].penalty_high == math.inf


def test_more_splits_and_more_depth_never_cost_more():
    solved = tune(blobs(depth=2)).solved
    assert [step[:2] for step in solved] == [(1, 1), (2, 1), (2, 2), (2, 3)]
    assert [step[2] for step in solved[1:]] == sorted((step[2] for step in solved[1:]), reverse=True)
    assert all(cost == bound for _, _, cost, bound in solved)


def test_validation_chooses_the_tree_that_generalises():
    rng = np.random.default_rng(0)
    x = rng.random((24, 1))
    labels = (x[:, 0] > 0.5).astype(int)
    noisy = labels.copy()
    noisy[:3] = 1 - noisy[:3]
    problem = Problem(x, noisy, depth=2)
    tuning = tune(problem, Problem(x, labels, depth=2))
    assert tuning.chosen.complexity == 1 and tuning.chosen.validation_cost == 0
    assert tuning.chosen.penalty_low < tuning.penalty < tuning.chosen.penalty_high


def test_hyperplanes_are_tuned_by_the_features_that_they_read():
    problem = blobs(9, depth=1, split="hyperplane")
    tuning = tune(problem, method="oct_h", most_splits=2)
    assert all(candidate.complexity <= 2 for candidate in tuning.candidates)


def test_validation_samples_of_other_classes_are_refused():
    with pytest.raises(ProblemError, match="class_names included"):
        tune(blobs(depth=1), Problem([[0.0, 1.0], [1.0, 2.0]], [0, 1], depth=1))


def test_a_feed_hands_trees_to_highs_while_it_runs():
    best = Split(3, 0.8, Leaf(0), Split(3, 1.75, Leaf(1), Leaf(2)))
    with Feed(lambda turn: best, most_turns=1) as feed:
        poor = Split(0, 5.5, Leaf(0), Leaf(2))
        limits = Limits(seconds=120)
        solution = solve_oct(uci("iris", depth=2), limits=limits, incumbent=poor, inject=feed, progress=stop_at_six)
    assert solution.objective == 6


def test_what_a_feed_s_source_raises_comes_out():
    def source(turn):
        raise ValueError("the source is dry")

    with Feed(source) as feed, pytest.raises(ValueError, match="dry"):
        solve_oct(uci("iris", depth=2), limits=Limits(seconds=20), inject=feed)
