"""What a bound on the regression grid is worth, far targets closed up, and when a tree may be called optimal."""

import math
from dataclasses import replace
from fractions import Fraction
from itertools import count
from types import SimpleNamespace

import numpy as np
import pytest

from octmip import Problem, Stop, certify, solve
from octmip.errors import CertificateError
from octmip.trees import _native
from octmip.trees.answer.solution import closing_tolerance
from octmip.trees.evidence.far_targets import FARTHEST, closed_up, reach
from octmip.trees.evidence.proof import check_proof
from octmip.trees.evidence.regression_log import log_scale
from octmip.trees.methods.options import ExactOptions
from octmip.trees.question.losses import SPELLINGS, AbsoluteError, SquaredError, number_loss
from octmip.trees.regression import grid as grid_module
from octmip.trees.regression.exact import exact_regression
from octmip.trees.regression.grid import Grid
from tests.oracles.regression_runs import Runs
from tests.oracles.regression_trees import least_objective, random_problem


def leaf_as_counted(problem):
    """Return the squared error of the best leaf on the grid, summed in float64 as the core sums it, and the bound."""
    grid = Grid.of(problem, problem.baseline)
    weight = first = square = 0.0
    for w, y, own in zip(grid.weights.tolist(), grid.targets.tolist(), grid.squares.tolist(), strict=True):
        weight, first, square = weight + w, first + w * y, square + own
    return grid.lower(max(0.0, square - first * first / weight))


def leaf_in_truth(problem):
    """Return the squared error of the best leaf, exactly: that of the mean, which float64 may not hold."""
    samples = problem.samples
    weights, targets = ([Fraction(x) for x in array.tolist()] for array in (samples.weights, samples.targets))
    first = sum(w * y for w, y in zip(weights, targets, strict=True))
    return sum(w * y * y for w, y in zip(weights, targets, strict=True)) - first * first / sum(weights)


@pytest.mark.parametrize("kind", ["rounded sums", "squares rounded up", "moved targets"])
def test_what_the_core_counts_proves_no_more_than_the_truth(kind):
    rng = np.random.default_rng(7)
    for _ in range(2):
        if kind == "rounded sums":  # one and the same number again and again, which is rounded the same way
            targets, weights = np.append(np.full(2000, 0.1), 1.1), np.full(2001, rng.random())
        elif kind == "squares rounded up":
            targets, weights = rng.integers(0, 1000, 400).astype(float), None
        else:  # all at the ends of their range, so that all move the same way
            targets, weights = np.repeat([0.1, 0.1 + rng.random()], 4000), None
        problem = Problem(np.zeros((len(targets), 1)), targets, weights=weights, depth=1, loss=SquaredError())
        bound, least = leaf_as_counted(problem), leaf_in_truth(problem)
        assert Fraction(bound) <= least
        assert bound == pytest.approx(float(least), rel=1e-8)


def test_medians_of_targets_that_all_move_apart_prove_no_more_than_the_truth():
    """Two targets, four thousand times each: on the grid both lie up to half a unit farther out than they do."""
    rng = np.random.default_rng(7)
    for _ in range(10):
        low, high = 0.1, 0.1 + rng.random()
        problem = Problem(np.zeros((8000, 1)), np.repeat([low, high], 4000), depth=1, loss=AbsoluteError())
        grid = Grid.of(problem, problem.baseline)
        assert grid.distance > 0
        counted = float((grid.targets.max() - grid.targets.min()) * 4000)
        least = 4000 * (Fraction(high) - Fraction(low))
        assert least * (1 - Fraction(1, 10**8)) < Fraction(grid.lower(counted)) <= least


def test_a_price_that_float64_adds_to_a_whole_cost_proves_no_more_than_the_truth():
    """A split that leaves one error costs 1 + 0.1, which float64 rounds up to 1.1."""
    problem = Problem(np.arange(4.0)[:, None], [0, 0, 5, 6], depth=1, loss=AbsoluteError(), leaf_penalty=0.1)
    grid, least = Grid.of(problem, problem.baseline), 1 + Fraction(0.1)
    counted = float(1 / grid.unit) + grid.penalty
    assert Fraction(counted) * grid.unit > least
    assert least * (1 - Fraction(1, 10**9)) < Fraction(grid.lower(counted)) <= least


@pytest.mark.parametrize("loss", SPELLINGS)
def test_a_limit_forgets_no_part_of_the_trees_within_a_budget(loss, monkeypatch):
    core = _native.regression
    n_early = 0
    for seed in range(12):
        drawn = random_problem(np.random.default_rng([77, seed]), loss, max_samples=9)
        costs = np.arange(1.0, drawn.samples.n_features + 1)
        columns = drawn.samples.features + 0.01 * np.arange(drawn.samples.n_samples)[:, None]
        problem = Problem(
            columns, drawn.samples.targets, depth=3, loss=number_loss(loss), sensor_cost=costs, sensor_budget=3
        )
        least = least_objective(problem)
        for last in range(1, 6):
            calls = count(1)

            def stopped(*asked, calls=calls, last=last, **question):
                found = core(*asked, **question)
                stop = "nodes" if next(calls) == last else found.stop
                return SimpleNamespace(rows=found.rows, bound=found.bound, stop=stop, n_nodes=found.n_nodes)

            monkeypatch.setattr(_native, "regression", stopped)
            early = exact_regression(problem)
            assert Fraction(early.bound) <= least, (seed, last)
            n_early += early.stop is Stop.NODES
    assert n_early > 8


@pytest.mark.parametrize("loss", SPELLINGS)
@pytest.mark.parametrize("far", [1e7, 1e12])
def test_tenths_with_a_far_target_are_proven_with_a_log(loss, far, tmp_path):
    rng = np.random.default_rng(3)
    for _ in range(2):
        targets = np.round(3 * rng.normal(size=30), 1)
        targets[int(rng.integers(30))] = far
        problem = Problem(rng.normal(size=(30, 2)), targets, depth=2, loss=number_loss(loss))
        solution, least = (
            exact_regression(problem, options=ExactOptions(proof=tmp_path / "proof.log")),
            Runs(problem).least(),
        )
        exact = problem.exact_objective(solution.tree)
        assert solution.stop is Stop.OPTIMAL
        assert float(abs(exact - least)) <= solution.tolerance <= 1e-8 * float(least)
        assert Fraction(check_proof(problem, tmp_path / "proof.log", bound=solution.bound).bound) <= least


def test_targets_closed_up_are_no_farther_apart_than_they_were():
    rng = np.random.default_rng(5)
    for _ in range(200):
        targets = rng.normal(size=12) * 10.0 ** rng.uniform(-3, 9, 12)
        exponent = int(rng.integers(-8, 20))
        near = closed_up(targets, exponent)
        apart, before = (np.abs(y[:, None] - y[None, :]) for y in (near, targets))
        assert (apart <= before + 1e-15 * np.ptp(near)).all()
        assert (np.diff(np.sort(near)) <= 2.0 ** (exponent + 1) * (1 + 1e-12)).all()
        kept = before <= 2.0**exponent
        assert apart[kept] == pytest.approx(before[kept], abs=1e-15 * np.ptp(near))
    assert closed_up(targets, FARTHEST) is targets


@pytest.mark.parametrize("loss", SPELLINGS)
def test_a_leaf_with_targets_that_far_apart_costs_more_than_the_known_tree(loss):
    rng = np.random.default_rng(6)
    for _ in range(100):
        weights, objective = 10.0 ** rng.uniform(-9, 9, 2), float(10.0 ** rng.uniform(-9, 9))
        problem = Problem([[0.0], [0.0]], [0.0, 1.0], weights=weights, depth=1, loss=number_loss(loss))
        apart = 2.0 ** reach(problem, objective)
        far = Problem([[0.0], [0.0]], [0.0, apart], weights=weights, depth=1, loss=number_loss(loss))
        assert far.baseline > 2 * objective
    assert reach(problem, 0.0) == FARTHEST


def test_a_tolerance_is_a_hundred_millionth_of_the_trees_own_objective():
    problem = Problem(np.arange(6.0)[:, None], [0.0, 1e6, 0.1, 0.4, 0.2, 0.3], depth=2, loss=SquaredError())
    good = solve(problem)
    assert good.is_optimal
    assert problem.least_saving_from(good.objective) == 1e-8 * good.objective
    bound = good.objective * (1 - 2e-8)
    assert closing_tolerance(good.objective, bound, problem.least_saving_from(good.objective)) == -1
    with pytest.raises(CertificateError, match="a hundred-millionth of the tree's objective"):
        certify(problem, replace(good, bound=bound, tolerance=math.nextafter(good.objective - bound, 1.0)))


def test_what_arithmetic_cannot_tell_apart_is_not_called_optimal():
    targets, weights = [0.1, 0.3, 0.7, 0.2], [1e12, 1e-9, 1e-9, 1e12]
    problem = Problem(np.arange(4.0)[:, None], targets, weights=weights, depth=1, loss=SquaredError())
    solution = solve(problem)
    assert certify(problem, solution).bound <= Runs(problem).least()
    assert solution.stop is Stop.NUMERICS


def test_a_log_that_closes_missing_readings_up_too_far_proves_less(tmp_path):
    problem, path = Problem(np.arange(4.0)[:, None], [0.0, 9.0, 0.0, 9.0], depth=1, loss=AbsoluteError()), tmp_path
    log = path / "proof.log"
    assert exact_regression(problem, options=ExactOptions(proof=log)).bound == 9
    grid = " ".join(map(str, log_scale(problem, 9.0)))
    nearer = " ".join([*grid.split(" ")[:3], "2"])
    log.write_text(log.read_text().replace(f"grid {grid}\n", f"grid {nearer}\n"))
    with pytest.raises(CertificateError, match="a tree costs"):
        check_proof(problem, log)


@pytest.mark.parametrize("kind", ["whole", "halves", "far", "tenths", "weighed", "spread", "equal"])
def test_targets_on_the_grid_are_as_near_as_is_said_and_their_sums_are_whole_where_weights_are(kind):
    rng = np.random.default_rng(len(kind))
    for _ in range(40):
        n, weights = int(rng.integers(2, 30)), np.ones(30)
        targets = rng.integers(-9, 9, n) * {"halves": 0.5, "tenths": 0.1, "far": 2.0**40}.get(kind, 1.0)
        targets = targets + {"far": 1.0, "equal": 0.1}.get(kind, 0.0) - targets * (kind == "equal")
        targets = targets * 10.0 ** rng.uniform(-9, 9, n) if kind == "spread" else targets
        weights = (rng.random(n) if kind == "weighed" else weights[:n] * rng.integers(1, 4, n)) + 0.0
        for steepest in (1, 9):
            exponent, moved, distance = grid_module._scaled_targets(targets, weights, steepest)
            off = [Fraction(y) * Fraction(2) ** exponent - Fraction(m) for y, m in zip(targets, moved, strict=True)]
            assert max(off) - min(off) <= 2 * Fraction(distance)
            assert (distance == 0) or kind not in ("whole", "halves", "equal")
            if kind != "weighed":
                assert (moved == np.rint(moved)).all() or kind == "equal"
                assert math.fsum(weights) * steepest * np.abs(moved).max() <= grid_module.CAPACITY
