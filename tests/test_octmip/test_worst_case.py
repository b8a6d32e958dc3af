"""Trees that survive reading errors against plain enumeration, which knows no bound, no rank and no solver."""

import math
from dataclasses import replace

import numpy as np
import pytest

from benchmarks.kinds.others import random_bands
from benchmarks.oracles.strategies import random_problem, random_tree
from octmip import ClassCosts, certify, predict
from octmip.errors import CertificateError, ProblemError
from octmip.trees.problem import Problem
from octmip.trees.solution import Limits, Stop
from octmip.trees.tree import Leaf, Split, n_splits
from octmip.trees.worst_case import Bands, certify_worst_case, solve, worst_case
from octmip.trees.worst_case.constant import first_beyond


def five_values(**options: object) -> Problem:
    """Return samples at 0, 1, 2, 3, 4 of classes a, a, a, b, b."""
    settings: dict[str, object] = {"depth": 1} | options
    return Problem(np.arange(5.0)[:, None], np.array(list("aaabb")), **settings)  # type: ignore[arg-type]


def test_samples_in_the_band_of_a_cut_count_on_both_sides() -> None:
    # At 2.5 and a band of 0.5: 2 may read 2.5 (left) at most, 3 may read 2.5 and go left; at 0.6 both may cross.
    tree = Split(0, 2.5, Leaf(0), Leaf(1))
    assert worst_case(five_values(), tree, 0.4).worst == 0
    assert worst_case(five_values(), tree, 0.5).worst == 1
    found = worst_case(five_values(), tree, 0.6)
    assert (found.plain, found.worst, found.gauges) == (0, 2, ("x0",))
    assert worst_case(five_values(), tree, {"x0": (0.6, 0.0)}).worst == 1


def test_one_constant_error_moves_all_samples_the_same_way() -> None:
    tree = Split(0, 2.5, Leaf(0), Leaf(1))
    found = worst_case(five_values(), tree, 0.6)
    assert found.worst == 2
    assert found.constant is not None
    assert found.constant.cost == 1
    assert found.constant.gauges == ("x0",)


@pytest.mark.parametrize("seed", range(40))
def test_the_worst_constant_error_is_that_of_a_fine_search(seed: int) -> None:
    rng = np.random.default_rng(seed)
    problem = random_problem(rng, max_depth=2)
    problem = replace(problem, features=np.round(problem.features * 2) / 2)
    tree = random_tree(rng, problem.n_features, problem.n_classes, 2)
    bands = Bands.of(problem, float(rng.integers(0, 4)) / 2)
    for off in (1, 2):
        found = worst_case(problem, tree, bands, off)
        assert found.constant is not None
        assert found.plain <= found.constant.cost <= found.worst * (1 + 1e-12)
        for _ in range(60):
            chosen = rng.permutation(len(problem.sensors))[:off]
            error = rng.uniform(-bands.below, bands.above) * np.isin(problem.sensor_index, chosen)
            moved = problem.objective_of(tree, predict(tree, problem.features + error))
            assert moved <= found.constant.cost * (1 + 1e-12)


def test_the_least_error_that_crosses_a_threshold_is_exact_to_the_last_bit() -> None:
    values = np.array([0.1, -3.0, 1e6, 2.5, 0.0])
    found = first_beyond(values, 0.3, -4.0, 5.0)
    for value, error in zip(values, found, strict=True):
        if math.isfinite(error):
            assert value + error > 0.3
            assert error == -4.0 or value + np.nextafter(error, -np.inf) <= 0.3
        else:
            assert value + 5.0 <= 0.3
    assert math.isfinite(first_beyond(np.array([1.0]), 2.0, -1.0, 1.5)[0])


def test_a_gauge_without_a_band_leaves_the_plain_optimum() -> None:
    problem = five_values()
    found = solve(problem, {})
    assert found.solution.objective == found.figures.plain == 0
    assert found.figures.gauges == ()
    assert certify(problem, found.solution).objective == 0


def test_two_gauges_that_agree_make_up_for_each_other() -> None:
    # Both gauges read the damage; a cut of either in the middle survives a band up to the gap between the classes.
    values = np.array([0.0, 1.0, 2.0, 8.0, 9.0, 10.0])
    problem = Problem(np.stack([values, values], axis=1), np.array([0, 0, 0, 1, 1, 1]), depth=2)
    assert solve(problem, 2.9).solution.objective == 0
    assert solve(problem, {"x0": 50.0, "x1": 2.9}).solution.tree == Split(1, 5.0, Leaf(0), Leaf(1))
    assert solve(problem, 50.0).solution.objective == 3


def test_deeper_trees_are_searched_with_the_plain_bound() -> None:
    rng = np.random.default_rng(3)
    problem = random_problem(rng, max_samples=30, max_depth=1)
    problem = replace(problem, depth=3, sensor_budget=None)
    found = solve(problem, 0.1, off=2, limits=Limits(seconds=2))
    assert found.plain_bound <= found.solution.bound <= found.solution.objective
    assert certify_worst_case(problem, found.solution, 0.1, 2).worst == found.solution.objective


def test_a_limit_returns_the_best_tree_and_a_bound_that_holds() -> None:
    rng = np.random.default_rng(0)
    features = rng.normal(size=(200, 4))
    problem = Problem(features, (features[:, 0] + features[:, 1] > 0) * 1, depth=2)
    full = solve(problem, 0.3)
    short = solve(problem, 0.3, limits=Limits(nodes=3))
    assert full.solution.stop is Stop.OPTIMAL
    assert short.solution.stop in (Stop.NODES, Stop.OPTIMAL)
    assert short.solution.bound <= full.solution.objective <= short.solution.objective


def test_one_thread_or_two_prove_the_same_value() -> None:
    rng = np.random.default_rng(1)
    features = rng.normal(size=(120, 3))
    problem = Problem(features, rng.integers(0, 3, 120), depth=2, leaf_size=5)
    assert solve(problem, 0.2).solution.objective == solve(problem, 0.2, n_jobs=2).solution.objective


@pytest.mark.parametrize(
    ("change", "reason"),
    [
        ({"objective": 3.0}, "claims the worst case 3.0"),
        ({"bound": 2.0, "stop": Stop.FINISHED}, "claims that no worst case is below 2.0"),
        ({"bound": -1.0}, "says optimal"),
        ({"tree": None, "objective": math.inf}, "found no tree"),
        ({"tolerance": 1.0}, "claims the tolerance"),
    ],
)
def test_a_wrong_claim_is_refuted(change: dict[str, object], reason: str) -> None:
    problem = five_values()
    found = solve(problem, 0.6).solution
    assert found.objective == 1
    with pytest.raises(CertificateError, match=reason):
        certify_worst_case(problem, replace(found, **change), 0.6)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("bands", "off", "reason"),
    [
        (-1.0, 1, "expected finite numbers of 0 or more"),
        ({"y": 1.0}, 1, "neither a sensor nor a feature"),
        ({"x0": (1.0, 2.0, 3.0)}, 1, "expected an amount, or a pair"),
        (1.0, 0, "off is 0"),
        (1e308 * 10, 1, "expected finite numbers"),
    ],
)
def test_wrong_bands_are_refused(bands: object, off: int, reason: str) -> None:
    with pytest.raises(ProblemError, match=reason):
        solve(five_values(), bands, off)  # type: ignore[arg-type]


def test_a_sensor_moves_all_its_features() -> None:
    problem = Problem(
        np.array([[0.0, 0.0], [0.0, 2.0], [2.0, 0.0], [2.0, 2.0]]),
        np.array([0, 1, 1, 1]),
        depth=2,
        sensor_of_feature=["g", "g"],
    )
    tree = Split(0, 1.0, Split(1, 1.0, Leaf(0), Leaf(1)), Leaf(1))
    assert worst_case(problem, tree, {"g": 1.5}).worst == 4
    assert worst_case(replace(problem, sensor_of_feature=None), tree, 1.5).worst == 2


def test_random_bands_reach_all_kinds() -> None:
    bands = [random_bands(np.random.default_rng(k), five_values(), 1.0) for k in range(50)]
    assert any(not given for given in bands)
    assert any(given and max(map(max, given.values())) > 1 for given in bands)  # type: ignore[type-var]
    assert n_splits(solve(five_values(), 0.1).solution.tree or Leaf(0)) == 1


def test_readings_of_float32_drift_as_their_values_of_float64_do() -> None:
    values = np.array([[1.0], [2.0]], dtype=np.float32)
    values.flags.writeable = False
    tree = Split(0, 1 + 1e-9, Leaf(0), Leaf(1))  # 1 + 2e-9 is 1 in float32, and would stay left
    found = worst_case(Problem(values, [0, 1], depth=1), tree, 2e-9)
    assert found.constant is not None
    assert (found.worst, found.constant.cost) == (1, 1)


def test_the_cheaper_of_two_leaves_is_found_where_their_costs_are_no_whole_numbers() -> None:
    """Both readings may be off by 3, so no split helps: one leaf costs 0.79 and the other 0.64."""
    problem = Problem([[0.0], [1.0]], [1, 0], depth=1, loss=ClassCosts([[0, 0.64], [0.79, 0]]))
    solution = solve(problem, 3.0).solution
    assert (solution.objective, solution.tolerance, solution.stop) == (0.64, 0.0, Stop.OPTIMAL)
