"""Sensors that trees choose, and what they are compared with."""

import numpy as np
import pytest

from octmip import Problem, certify
from octmip.errors import DataError, ProblemError
from octmip.sensing import (
    Imputation,
    by_chance,
    label_bound,
    place_sensors,
    placement_frontier,
    placement_on,
)
from octmip.sensing.placement import problem_on
from octmip.trees.methods.options import SearchOptions
from tests.oracles.enumeration import optimum
from tests.oracles.strategies import random_problem


def readings(n: int = 120, p: int = 8) -> Problem:
    """Return a problem that sensors s1 and s3 decide: s0 reads highest and decides nothing; two features each."""
    rng = np.random.default_rng(0)
    features = rng.normal(size=(n, p))
    features[:, :2] += 50.0
    labels = (features[:, 2] > 0).astype(int) + 2 * (features[:, 6] > 0.3).astype(int)
    return Problem(
        features, labels, depth=2, sensor_of_feature=[f"s{j // 2}" for j in range(p)], sensor_cost=[1.0, 2.0, 1.0, 4.0]
    )


def test_the_best_tree_says_which_sensors_to_install():
    problem = readings()
    found = place_sensors(problem)
    assert found.sensors == ("s1", "s3")
    assert found.cost == 6.0
    assert found.solution.objective == 0
    assert found.solution.is_optimal


@pytest.mark.parametrize("split", ["axis", "hyperplane"])
def test_a_placement_is_never_worse_than_the_choices_it_starts_from(split):
    rng = np.random.default_rng(4)
    problem = Problem(rng.normal(size=(80, 12)), rng.integers(0, 3, 80), depth=3, split=split)
    quick = {"method": "search", "options": SearchOptions(restarts=1, perturbations=0)}
    starts = [by_chance(problem, 4, rng) for _ in range(3)]
    least = min(placement_on(problem, sensors, **quick).solution.objective for sensors in starts)
    assert place_sensors(problem, starts=starts, **quick).solution.objective <= least
    narrow = problem.replace(sensor_budget=4.0)
    assert place_sensors(narrow, starts=starts, **quick).cost <= 4
    with pytest.raises(ProblemError, match="elsewhere"):
        place_sensors(problem, starts=[["elsewhere"]])


def test_a_placement_on_given_sensors_reads_no_others_and_is_the_same_tree_on_its_own_choice():
    problem = readings()
    chosen = placement_on(problem, ("s3", "s1"))
    assert chosen.sensors == ("s1", "s3")
    assert chosen.problem.samples.n_features == 4
    assert chosen.solution.objective == 0
    worse = placement_on(problem, ("s0", "s2"))
    assert worse.cost == 2.0
    assert worse.solution.objective > 0
    assert certify(worse.problem, worse.solution).sensors
    with pytest.raises(ProblemError, match="s9"):
        placement_on(problem, ("s9",))


def test_a_part_of_a_problem_keeps_which_features_may_meet():
    problem = readings().replace(split="hyperplane", allowed_splits=[[0, 2], [3, 6], [0, 1]])
    part = problem_on(problem, ["s1", "s3"])
    assert part.shape.allowed_splits == ((0,), (1, 2))
    assert part.samples.feature_names == ("x2", "x3", "x6", "x7")
    assert part.shape.sensor_costs.tolist() == [2.0, 4.0]


def test_the_frontier_is_proven_for_every_number_and_every_cost():
    problem = readings()
    by_number = placement_frontier(problem)
    assert [point.value for point in by_number] == [1, 2, 3]
    assert all(point.solution.is_optimal for point in by_number)
    assert by_number[1].solution.objective == 0
    by_cost = placement_frontier(problem, "cost", [1, 2, 5, 6])
    objectives = [point.solution.objective for point in by_cost]
    assert objectives == sorted(objectives, reverse=True)
    assert objectives[-1] == 0 < objectives[-2]
    for point in by_cost:
        assert point.problem.shape.sensor_cost_of(point.solution.tree) <= point.value
    with pytest.raises(ProblemError, match="name the values"):
        placement_frontier(problem, "cost")


@pytest.mark.parametrize("seed", range(15))
def test_no_bound_lies_above_the_optimum(seed):
    rng = np.random.default_rng(seed)
    problem = random_problem(rng, max_samples=9, max_depth=2)
    least = optimum(problem).objective
    slack = 1e-9 * max(1.0, least)
    assert label_bound(problem) <= least + slack


def test_filling_is_the_regression_on_the_others():
    rng = np.random.default_rng(3)
    means = 500.0 + np.outer(np.arange(4) * 60.0, np.linspace(1.0, 0.5, 8))
    readings = means[rng.integers(0, 4, 400)] + rng.normal(0, 8.0, (400, 8))
    imputation = Imputation.fit(readings)
    gap = readings.copy()
    gap[:, 2] = np.nan
    others = np.delete(readings, 2, axis=1)
    design = np.column_stack([np.ones(len(others)), others])
    slope, *_ = np.linalg.lstsq(design, readings[:, 2], rcond=None)
    assert np.allclose(imputation.impute(gap)[:, 2], design @ slope)
    assert np.allclose(imputation.impute(np.full((1, 8), np.nan)), readings.mean(axis=0))
    assert (imputation.impute(readings) == readings).all()
    with pytest.raises(DataError, match=r"\(400, 3\); expected \(n, 8\)"):
        imputation.impute(readings[:, :3])
