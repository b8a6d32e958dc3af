"""Failure of sensors: robust trees against enumeration, surrogates, imputation, detection with its rate."""

from dataclasses import replace

import numpy as np
import pytest

from benchmarks.oracles.failure import losses
from octmip import Limits, Problem, solve
from octmip.errors import CertificateError, DataError, ProblemError
from octmip.sensing import (
    FailureProblem,
    Fault,
    FaultDetector,
    Imputation,
    Scenario,
    certify_failures,
    failures,
    power,
    solve_expected,
    solve_worst,
    with_surrogates,
)
from octmip.sensing.failure import robust
from octmip.solution import Stop
from octmip.tree import HyperplaneSplit, Leaf, Split, predict


def random_failures(seed: int) -> FailureProblem:
    """Return a small problem of depth 1 or 2 whose sensors fail in some way."""
    rng = np.random.default_rng(seed)
    n, p, k = int(rng.integers(4, 8)), int(rng.integers(1, 3)), int(rng.integers(2, 4))
    labels = np.concatenate([np.arange(k), rng.integers(0, k, n - k)])
    weights = None if rng.random() < 0.5 else rng.integers(1, 4, n)
    problem = Problem(rng.integers(0, 4, (n, p)).astype(float), labels, depth=2, weights=weights)
    fault = [Fault("stuck", 0.0), Fault("stuck", 2.0), Fault("drift", 1.0), Fault("noise", 1.0)][rng.integers(4)]
    return FailureProblem(problem, failures(problem, fault, probability=float(rng.choice([0.5, 0.3, 1.0]))), seed)


def every_loss(asked: FailureProblem) -> np.ndarray:
    """Return the losses of all trees, the readings made here by other code than the package's."""
    problem = asked.problem
    readings = [problem.features]
    for number, scenario in enumerate(asked.scenarios, start=1):
        out = problem.features.copy()
        column = problem.feature_names.index(scenario.sensors[0])
        noise = np.random.default_rng([asked.seed, number]).normal(0.0, max(scenario.fault.size, 0), (len(out), 1))[
            :, 0
        ]
        changed = {
            "stuck": np.full(len(out), scenario.fault.size),
            "drift": out[:, column] + scenario.fault.size,
            "noise": out[:, column] + noise,
        }
        out[:, column] = changed[scenario.fault.kind]
        readings.append(out)
    return losses(readings, problem.codes, problem.weights, problem.costs)


@pytest.mark.parametrize("block", range(3))
def test_the_robust_trees_are_those_of_enumeration(block):
    for seed in range(block * 8, block * 8 + 8):
        asked = random_failures(seed)
        table = every_loss(asked)
        expected = solve_expected(asked)
        assert expected.is_optimal, seed
        assert certify_failures(asked, expected).expected == pytest.approx((table @ asked.probabilities).min()), seed
        worst = solve_worst(asked)
        certify_failures(asked, worst)
        least = table.max(axis=1).min()
        assert worst.bound - 1e-9 <= least <= worst.objective + 1e-9, seed


def gauges(n: int = 400, n_gauges: int = 8) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return readings of redundant gauges, levels of damage, and the gauges' mean at each level."""
    rng = np.random.default_rng(3)
    means = 500.0 + np.outer(np.arange(4) * 60.0, np.linspace(1.0, 0.5, n_gauges))
    level = rng.integers(0, 4, n)
    return means[level] + rng.normal(0, 8.0, (n, n_gauges)), level, means


def test_a_tree_that_does_not_read_the_failed_sensor_loses_nothing():
    readings, level, _ = gauges()
    problem = Problem(readings, level, depth=2)
    asked = FailureProblem(problem, failures(problem))
    tree = Split(0, 530.0, Leaf(0), Leaf(2))
    objectives = asked.objectives(tree)
    assert (objectives[2:] == objectives[0]).all()
    assert objectives[1] > objectives[0]


def test_robust_trees_lose_less_in_what_they_were_made_for():
    readings, level, _ = gauges()
    problem = Problem(readings, level, depth=2)
    asked = FailureProblem(problem, failures(problem, probability=0.5))
    ordinary = asked.objectives(solve(problem).tree)
    expected, worst = certify_failures(asked, solve_expected(asked)), certify_failures(asked, solve_worst(asked))
    assert expected.expected <= asked.probabilities @ ordinary
    assert worst.worst <= ordinary.max()


def test_whoever_loses_the_root_keeps_one_level():
    readings, level, _ = gauges()
    problem = Problem(readings, level, depth=2)
    worst = solve_worst(FailureProblem(problem, failures(problem)), rounds=1)
    without = [solve(Problem(np.delete(readings, j, axis=1), level, depth=1)).objective for j in range(8)]
    assert worst.bound >= min(without)


def test_hyperplanes_are_made_robust_by_search():
    readings, level, _ = gauges(80, 4)
    problem = Problem(readings, level, depth=1, split="hyperplane", split_size=2)
    asked = FailureProblem(problem, failures(problem, Fault("drift", 30.0)))
    ordinary = asked.probabilities @ asked.objectives(solve(problem).tree)
    assert certify_failures(asked, solve_expected(asked)).expected <= ordinary
    assert certify_failures(asked, solve_worst(asked, rounds=2)).worst >= solve_worst(asked, rounds=2).bound


def test_a_limit_returns_no_tree_that_expects_more_than_the_ordinary_one(monkeypatch):
    readings, level, _ = gauges(80, 4)
    problem = Problem(readings, level, depth=2)
    asked = FailureProblem(problem, failures(problem))
    ordinary = solve(problem)

    def cut_off(one, *given, **named):
        if one is problem:
            return ordinary
        leaf = Leaf(0)
        return replace(ordinary, tree=leaf, objective=one.objective(leaf), bound=0.0, stop=Stop.TIME)

    monkeypatch.setattr(robust, "solve", cut_off)
    found = solve_expected(asked, limits=Limits(seconds=1.0))
    assert found.tree == ordinary.tree
    assert certify_failures(asked, found).expected == pytest.approx(asked.probabilities @ asked.objectives(found.tree))


def test_an_interrupt_of_the_ordinary_problem_ends_the_rest(monkeypatch):
    readings, level, _ = gauges(80, 4)
    problem = Problem(readings, level, depth=2)
    asked = FailureProblem(problem, failures(problem))
    given = []

    def interrupted(one, method, limits, **named):
        given.append(limits.seconds)
        leaf = Leaf(0)
        stop = Stop.INTERRUPTED if one is problem else Stop.TIME
        return replace(ordinary, tree=leaf, objective=one.objective(leaf), bound=0.0, stop=stop)

    ordinary = solve(problem)
    monkeypatch.setattr(robust, "solve", interrupted)
    assert solve_expected(asked, limits=Limits(seconds=10.0)).stop is Stop.INTERRUPTED
    assert given == [2.0, 0.0]


def test_two_failures_together_are_one_scenario():
    readings, level, _ = gauges(60, 4)
    problem = Problem(readings, level, depth=1)
    assert len(failures(problem, n_failed=2)) == 6
    asked = FailureProblem(problem, failures(problem, n_failed=2, probability=0.6))
    assert asked.probabilities.sum() == pytest.approx(1.0)
    assert (asked.readings(1)[:, :2] == 0).all()
    assert (asked.readings(1)[:, 2:] == readings[:, 2:]).all()


def test_a_false_claim_about_failures_is_refuted():
    readings, level, _ = gauges(60, 4)
    problem = Problem(readings, level, depth=1)
    asked = FailureProblem(problem, failures(problem))
    solution = solve_expected(asked)
    with pytest.raises(CertificateError, match="recounted"):
        certify_failures(asked, replace(solution, objective=solution.objective - 1))
    with pytest.raises(CertificateError, match="recounted"):
        certify_failures(asked, replace(solution, bound=solution.objective + 1))


def test_a_limit_leaves_the_bounds_of_the_worst_case_true():
    asked = random_failures(1)
    least = every_loss(asked).max(axis=1).min()
    for seconds in (5.0, 0.0):
        worst = solve_worst(asked, rounds=1, limits=Limits(seconds=seconds))
        assert worst.bound - 1e-9 <= least <= worst.objective + 1e-9


@pytest.mark.parametrize(
    ("options", "says"),
    [
        ({"leaf_size": 5}, "leaf_size"),
        ({"scenarios": ()}, "no scenario"),
        ({"scenarios": (Scenario(("x9",), Fault("stuck"), 0.1),)}, "x9"),
        ({"scenarios": (Scenario(("x0",), Fault("stuck"), 0.8),) * 2}, "sum to 1.6"),
    ],
)
def test_what_makes_no_failure_problem_is_refused(options, says):
    readings, level, _ = gauges(40, 3)
    problem = Problem(readings, level, depth=1, leaf_size=options.get("leaf_size", 1))
    with pytest.raises(ProblemError, match=says):
        FailureProblem(problem, options.get("scenarios", failures(problem)))
    with pytest.raises(ProblemError):
        Fault("melted")
    with pytest.raises(ProblemError, match="n_failed"):
        failures(problem, n_failed=4)


def test_surrogates_answer_as_the_tree_without_gaps_and_nearly_so_with_one():
    readings, level, _ = gauges()
    problem = Problem(readings, level, depth=2)
    tree = solve(problem).tree
    guarded = with_surrogates(problem, tree)
    assert (guarded.predict(readings) == predict(tree, readings)).all()
    for gauge in {split.feature for split in (tree, tree.left, tree.right)}:
        gap = readings.copy()
        gap[:, gauge] = np.nan
        lone = with_surrogates(problem, tree, 0).predict(gap)
        assert (guarded.predict(gap) != level).mean() < 0.5 * (lone != level).mean()


def test_a_surrogate_may_point_the_other_way_and_the_best_comes_first():
    x = np.arange(10.0)
    problem = Problem(np.column_stack([x, -x, np.where(x == 4, 9, x)]), x > 4, depth=1)
    guarded = with_surrogates(problem, Split(0, 4.5, Leaf(0), Leaf(1)))
    first, second = guarded.root.surrogates
    assert (first.feature, first.is_reversed, first.threshold, first.agreement) == (1, True, -4.5, 1.0)
    assert (second.feature, second.is_reversed, second.agreement) == (2, False, 0.9)
    assert guarded.predict(np.array([[np.nan, -9.0, 0.0], [np.nan, np.nan, 0.0], [np.nan] * 3])).tolist() == [1, 0, 0]
    exported = guarded.as_dict(("a", "b", "c"), (False, True))
    assert exported["surrogates"][0] == {"feature": "b", "left_if": "above", "threshold": -4.5, "agreement": 1.0}


def test_a_surrogate_comes_from_another_sensor_and_beats_the_larger_side():
    x = np.arange(10.0)
    columns = np.column_stack([x, x, np.zeros(10)])
    problem = Problem(columns, x > 4, depth=1, sensor_of_feature=["a", "a", "b"])
    assert with_surrogates(problem, Split(0, 4.5, Leaf(0), Leaf(1))).root.surrogates == ()


def test_hyperplanes_have_surrogates_too():
    readings, level, _ = gauges()
    problem = Problem(readings, level, depth=1, split="hyperplane")
    tree = HyperplaneSplit((0, 1), (1.0, 1.0), 1170.0, Leaf(0), Leaf(3))
    gap = readings.copy()
    gap[:, 1] = np.nan
    found = with_surrogates(problem, tree).predict(gap)
    assert (found != predict(tree, readings)).mean() < 0.15
    with pytest.raises(DataError):
        with_surrogates(problem, tree).predict(readings[0])


def test_filling_is_the_regression_on_the_others():
    readings, _, _ = gauges()
    imputation = Imputation.fit(readings)
    gap = readings.copy()
    gap[:, 2] = np.nan
    others = np.delete(readings, 2, axis=1)
    design = np.column_stack([np.ones(len(others)), others])
    slope, *_ = np.linalg.lstsq(design, readings[:, 2], rcond=None)
    assert np.allclose(imputation.impute(gap)[:, 2], design @ slope)
    assert np.allclose(imputation.impute(np.full((1, 8), np.nan)), readings.mean(axis=0))
    assert (imputation.impute(readings) == readings).all()


@pytest.fixture(scope="module")
def detector() -> FaultDetector:
    """Return a detector over the redundant gauges."""
    return FaultDetector(gauges()[2], 8.0, tuple(f"g{j}" for j in range(8)))


def test_the_false_alarm_rate_is_the_stated_one(detector):
    healthy = detector.draw(20_000, np.random.default_rng(5))
    assert detector.is_alarm(healthy).mean() == pytest.approx(0.01, abs=0.003)  # four standard errors


def test_power_rises_with_the_fault_and_names_the_gauge(detector):
    found, right = power(detector, [0.0, 20.0, 40.0, 80.0], 200, np.random.default_rng(6))
    assert (np.diff(found.mean(axis=1)) > 0).all()
    assert found[3].min() > 0.99
    assert right[3].min() > 0.99


def test_the_surprise_is_the_predictive_density(detector):
    reading = detector.draw(1, np.random.default_rng(7))[0]
    z = (reading - detector.means) / 8.0
    density = np.exp(-0.5 * z**2) / np.sqrt(2 * np.pi)
    others = np.delete(density, 3, axis=1).prod(axis=1)
    predictive = (others / others.sum()) @ density[:, 3]
    assert detector.surprise(reading[None])[0, 3] == pytest.approx(-np.log(predictive))


def test_a_named_gauge_is_taken_out_and_a_missing_one_is_no_alarm(detector):
    readings = detector.draw(50, np.random.default_rng(8))
    readings[:, 4] = 0.0
    assert np.isnan(detector.without_failed(readings)[:, 4]).all()
    gap = detector.draw(500, np.random.default_rng(9))
    gap[:, 4] = np.nan
    assert detector.is_alarm(gap).mean() < 0.04
    with pytest.raises(DataError):
        detector.surprise(readings[:, :3])


def test_more_readings_averaged_find_smaller_faults(detector):
    many = replace_averaged(detector, 9)
    few, more = (power(d, [25.0], 200, np.random.default_rng(1))[0].mean() for d in (detector, many))
    assert more > few + 0.2


def replace_averaged(detector: FaultDetector, n: int) -> FaultDetector:
    return FaultDetector(detector.means, 8.0, detector.gauges, n_averaged=n)


def test_a_bound_above_the_worst_failure_is_not_hidden():
    problem = Problem([[0.0], [1.0]], [0, 1], depth=1)
    asked = FailureProblem(problem, failures(problem, Fault("stuck")))
    game = robust._Game(asked, tree=Leaf(0), worst=1.0, bound=1.5)
    assert game.solution(0.0, 0).bound == 1.5
    with pytest.raises(CertificateError):
        certify_failures(asked, game.solution(0.0, 0))
