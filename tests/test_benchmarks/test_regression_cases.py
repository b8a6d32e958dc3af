"""The regression families: no problem of the first chunk disagrees, and the study's row of numbers has every rule."""

from collections import Counter

import numpy as np
import pytest

from benchmarks.cases.regression.agreement import complaint
from benchmarks.cases.regression.speed import made_up
from benchmarks.cases.regression.wide import STREAMS, judged, wide_problem
from benchmarks.uav.numbers import markdown, rows_of
from femlib.dataset import Recipe, build_dataset, simulated_strains
from femlib.wing import uav_wing
from octmip.trees.losses import SPELLINGS, AbsoluteError, SquaredError


def test_random_problems_agree_with_enumeration():
    assert [reason for seed in range(20) for loss in SPELLINGS if (reason := complaint(seed, loss))] == []


@pytest.mark.parametrize(("kind", "n"), [("wide", 60), ("far", 150), ("wide quantiles", 40), ("far quantiles", 60)])
def test_many_samples_and_far_targets_are_proven_right_and_their_corrupted_logs_are_refused(kind, n):
    outcomes = [judged(kind, seed) for seed in range(n)]
    assert [reason for reason, _ in outcomes if reason] == []
    counts = sum((counts for _, counts in outcomes), Counter())
    assert counts[f"{kind}: problems"] == n
    assert counts[f"{kind}: corrupted logs, refused"] > 4 * n


def test_a_problem_that_the_bound_of_clusters_got_wrong_is_among_them():
    rng = np.random.default_rng([STREAMS["wide"], 60])
    problem = wide_problem(rng, (SquaredError(), AbsoluteError()))
    assert len(np.unique(problem.targets)) > 16
    assert judged("wide", 60)[0] is None


def test_a_log_closes_only_what_the_checker_finds_closed_where_rounded_bounds_do_not_grow_from_cut_to_cut():
    assert judged("far", 1485)[0] is None


def test_made_up_samples_are_the_same_every_time():
    features, targets = made_up(50)
    assert features.shape == (50, 10)
    assert np.array_equal(made_up(50)[1], targets)


def test_numbers_of_the_study_are_judged_by_every_rule():
    data = build_dataset(simulated_strains(uav_wing()), Recipe(samples_per_state=4), seed=0)
    rows = list(rows_of(data, (1,), 5.0))
    assert len(rows) == 14
    squared = next(row for row in rows if row["rule"] == "regression tree, squared error")
    greedy = next(row for row in rows if row["rule"] == "scikit-learn DecisionTreeRegressor")
    assert squared["rmse_train"] <= greedy["rmse_train"] + 1e-9
    assert markdown(rows).count("\n|") == 16
