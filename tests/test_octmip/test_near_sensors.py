"""What each sensor is worth, against enumeration: the optimum without it, and of the trees that read it."""

import math
from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest

from octmip import ClassCosts, Solution, sensor_roles, solve
from octmip.errors import ProblemError
from octmip.trees.answer.certificate import checked_leaf_index
from octmip.trees.answer.set_certificate import recount
from octmip.trees.answer.solution import Limits, Stop
from octmip.trees.near_sets import Role, SensorRole, roles, without
from octmip.trees.near_sets.without import Calls, loss_of
from octmip.trees.question.problem import Problem
from tests.oracles.enumeration import optimum
from tests.oracles.strategies import random_problem

CLOSE = Fraction(1, 10**9)


def optimum_without(problem: Problem, sensors: tuple[str, ...]) -> float:
    names = enumerate(problem.shape.sensor_of_feature or ())
    kept = [[f] for f, name in names if name not in sensors and problem.shape.is_allowed((f,))]
    return optimum(problem.replace(allowed_splits=kept)).objective if kept else problem.baseline


def check_forced(problem: Problem, role: SensorRole, best: float) -> None:
    """Some tree within a hair of the objective reads the sensor, and none within a hair less."""
    most = Fraction(float(problem.samples.weights.sum() * problem.costs.max()) + 7 * problem.shape.leaf_penalty)
    limit = Fraction(role.forced) if math.isfinite(role.forced) else most
    readers = recount(problem, limit * (1 + CLOSE)).by_sensors
    assert any(role.sensor in read for read in readers) == math.isfinite(role.forced)
    if limit * (1 - CLOSE) > best and math.isfinite(role.forced):
        assert not any(role.sensor in read for read in recount(problem, limit * (1 - CLOSE)).by_sensors)


@pytest.mark.parametrize("seed", range(15))
def test_objectives_without_and_forced_are_those_of_enumeration(seed: int) -> None:
    rng = np.random.default_rng(seed)
    problem = random_problem(rng, max_samples=int(rng.integers(4, 9)))
    found = sensor_roles(problem, pairs=True)
    assert found.is_proven
    assert found.stop is Stop.FINISHED
    best = optimum(problem).objective
    assert math.isclose(found.solution.objective, best)
    for loss in (*(role.without for role in found.roles), *found.pairs):
        assert math.isclose(loss.objective, optimum_without(problem, loss.sensors), abs_tol=1e-12)
        checked_leaf_index(problem, loss.tree)
        assert not set(loss.sensors) & set(loss.read)
    for role in found.roles:
        check_forced(problem, role, best)


def decimal(seed: int) -> Problem:
    """Return a problem of decimal weights and costs, whose sums in float64 depend on their order."""
    rng = np.random.default_rng(seed)
    n = int(rng.integers(4, 8))
    labels = rng.integers(0, 2, n)
    labels[:2] = 0, 1
    costs = rng.choice([0.1, 0.3, 0.7, 1.1], (2, 2)) * (1 - np.eye(2))
    weights = rng.choice([0.1, 0.2, 0.3, 0.7], n)
    return Problem(
        rng.integers(0, 3, (n, 3)), labels, depth=int(rng.integers(1, 3)), weights=weights, loss=ClassCosts(costs)
    )


def role_by_enumeration(problem: Problem, sensor: str, limit: Fraction) -> Role:
    sets = recount(problem, limit).by_sensors
    n_reading = sum(sensor in read for read in sets)
    return Role.USELESS if not n_reading else Role.NEEDED if n_reading == len(sets) else Role.REPLACEABLE


@pytest.mark.parametrize("within", [0.0, 0.1])
def test_roles_are_those_of_enumeration_in_exact_arithmetic(within: float) -> None:
    for seed in range(15):
        problem = decimal(seed)
        found = sensor_roles(problem, within)
        assert found.is_proven
        worst = Fraction(float(problem.samples.weights.sum() * problem.costs.max()))
        assert found.limit == recount(problem, worst).least + Fraction(within), f"seed {seed}"
        for role in found.roles:
            assert role.role is role_by_enumeration(problem, role.sensor, found.limit), f"seed {seed}, {role.sensor}"


def test_a_sensor_that_the_optimal_tree_reads_is_not_useless() -> None:
    features = [[1, 0], [2, 1], [0, 0], [1, 0], [0, 0]]
    weights, costs = [0.1, 0.1, 0.3, 0.1, 0.7], [[0, 0.7], [0.1, 0]]
    found = sensor_roles(Problem(features, [0, 1, 0, 1, 1], depth=1, weights=weights, loss=ClassCosts(costs)))
    assert found.problem.shape.sensors_used(found.solution.tree)
    assert [role.role for role in found.roles] == [Role.REPLACEABLE, Role.REPLACEABLE]


def stairs(n: int = 12) -> Problem:
    """Return samples that the first feature parts, the second all but one, the third not at all."""
    rng = np.random.default_rng(0)
    labels = np.arange(n) % 2
    almost = labels.copy()
    almost[0] = 1
    return Problem(
        np.column_stack([labels, almost, rng.permutation(n)]).astype(float),
        labels,
        depth=1,
        feature_names=("exact", "almost", "noise"),
    )


def test_roles_follow_from_the_objectives() -> None:
    found = sensor_roles(stairs())
    exact, almost, noise = found.roles
    assert [role.role for role in found.roles] == [Role.NEEDED, Role.USELESS, Role.USELESS]
    assert (exact.without.objective, exact.forced, exact.instead) == (1.0, 0.0, ("almost",))
    assert (almost.without.objective, almost.forced) == (0.0, 1.0)
    assert noise.forced > 1
    wider = sensor_roles(stairs(), within=1.0)
    assert [role.role for role in wider.roles] == [Role.REPLACEABLE, Role.REPLACEABLE, Role.USELESS]


def test_without_time_nothing_is_claimed_that_is_not_proven() -> None:
    rng = np.random.default_rng(5)
    problem = Problem(rng.normal(size=(80, 5)), rng.integers(0, 3, 80), depth=3)
    found = sensor_roles(problem, limits=Limits(seconds=0.0))
    assert not found.is_proven
    assert found.stop is Stop.TIME
    for role in found.roles:
        assert role.without.bound <= role.without.objective


def test_what_is_asked_must_make_sense() -> None:
    with pytest.raises(ProblemError, match="within is -1"):
        sensor_roles(stairs(), within=-1)
    with pytest.raises(ProblemError, match="split is 'hyperplane'"):
        sensor_roles(stairs().replace(split="hyperplane"))


def told_apart() -> Problem:
    """Return a problem whose labels sensor a tells apart without an error, and sensor b with two of six."""
    features = [[0.0, 0.0], [1.0, 0.0], [2.0, 1.0], [3.0, 0.0], [4.0, 1.0], [5.0, 1.0]]
    return Problem(features, [0, 0, 0, 1, 1, 1], depth=1, feature_names=("a", "b"))


def test_the_bound_without_a_sensor_says_nothing_of_trees_without_another(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Without a two samples are wrong, proven; a search without b that proves nothing has no bound of two."""
    problem = told_apart()
    calls = Calls(problem, Limits(), 0, 1, None, 0.0)
    calls.known.append(loss_of(problem, (), solve(problem)))
    assert calls.without(("a",)).bound == 2

    def unproven(problem: Problem, *_: object) -> Solution:
        return Solution(problem.best_leaf(), problem.baseline, 0.0, Stop.TIME, 0.0, 1, "exact", "1", 0)

    calls.known[0] = replace(calls.known[0], read=("a", "b"))  # as if the best tree had read both
    monkeypatch.setattr(without, "solve", unproven)
    found = calls.without(("b",))
    assert (found.bound, found.least, found.is_proven) == (0, 0, False)


def test_a_sensor_is_not_called_useless_while_trees_that_read_it_are_left(monkeypatch: pytest.MonkeyPatch) -> None:
    problem = told_apart()
    assert [role.role for role in sensor_roles(problem).roles] == [Role.NEEDED, Role.USELESS]
    monkeypatch.setattr(roles, "_least", lambda _readers, known, _calls: ([None] * len(known), Stop.TIME))
    found = sensor_roles(problem)
    assert [role.role for role in found.roles] == [Role.NEEDED, Role.UNKNOWN]
    assert not found.is_proven
