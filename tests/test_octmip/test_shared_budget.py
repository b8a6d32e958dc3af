"""Several labels under one budget of sensors: against enumeration of sensor sets."""

import math
from dataclasses import replace
from itertools import combinations

import numpy as np
import pytest

from octmip import Limits, Problem, Stop
from octmip.errors import CertificateError, ProblemError
from octmip.sensing import JointSolution, certify_joint, shared_budget
from octmip.sensing.sensor_sets import SetSearch
from octmip.trees.methods.options import SearchOptions
from tests.oracles.enumeration import optimum
from tests.oracles.strategies import random_problem


def random_labels(rng: np.random.Generator, n_labels: int) -> list[Problem]:
    """Return problems over the same features and sensors, each with labels, costs and weights of its own."""
    first = random_problem(rng, max_samples=9, max_features=4, max_depth=2)
    p = first.samples.n_features
    price = rng.choice([0.0, 0.5, 1.0, 2.0, 0.1], p) if rng.random() < 0.5 else np.ones(p)
    problems = []
    for _ in range(n_labels):
        codes = rng.permutation(first.samples.codes)
        labels = np.array(first.samples.class_names)[codes]
        own = first.replace(targets=labels, sensor_cost=None, sensor_of_feature=None)
        problems.append(own.replace(sensor_budget=None, sensor_cost=price.tolist(), allowed_splits=None))
    return problems


def rivals(rng: np.random.Generator) -> list[Problem]:
    """Return labels that need sensors of their own, more than the budgets of the tests pay for."""
    features = rng.integers(0, 4, (10, 5)).astype(float)
    problems = []
    for _ in range(int(rng.integers(2, 4))):
        pair = features[:, rng.choice(5, 2, replace=False)]
        labels = (pair.sum(axis=1) > 3).astype(int)
        labels[rng.integers(10)] ^= 1
        labels[:2] = [0, 1]
        weights = rng.integers(1, 4, 10).astype(float)
        problems.append(Problem(features, labels, depth=int(rng.integers(1, 3)), weights=weights))
    return problems


def joint_optimum(problems: list[Problem], weights: list[float], budget: float) -> float:
    """Return the least weighted sum over every set of sensors within the budget, each label enumerated on the set."""
    names, least = problems[0].shape.sensors, math.inf
    for size in range(len(names) + 1):
        for chosen in combinations(range(len(names)), size):
            if math.fsum(problems[0].shape.sensor_costs[list(chosen)]) <= budget + 1e-9 * max(1.0, budget):
                allowed = [[j] for j in chosen]
                found = [optimum(p.replace(allowed_splits=allowed)).objective for p in problems]
                least = min(least, math.fsum(w * value for w, value in zip(weights, found, strict=True)))
    return least


@pytest.mark.parametrize("seed", range(10))
def test_the_proven_optimum_is_that_of_enumeration(seed):
    rng = np.random.default_rng(seed)
    problems = random_labels(rng, int(rng.integers(1, 4)))
    weights = [1.0] * len(problems) if rng.random() < 0.5 else rng.choice([0.5, 1.0, 3.0], len(problems)).tolist()
    budget = float(rng.integers(0, 4))
    joint = shared_budget(problems, budget, weights=weights)
    assert joint.stop is Stop.OPTIMAL
    assert joint.is_optimal
    assert joint.objective == pytest.approx(joint_optimum(problems, weights, budget), rel=1e-9, abs=1e-9)


def without_good_trees(monkeypatch):
    """Leave the search over sets without good trees from elsewhere: a bound that is too high then shows itself."""
    monkeypatch.setattr(SetSearch, "_alternate", lambda search, trees: None)
    monkeypatch.setattr(SetSearch, "_repaired", lambda search, solutions, held=frozenset(): search.best)


def test_a_limit_leaves_a_bound_that_holds_although_the_best_trees_are_not_found_yet(monkeypatch):
    without_good_trees(monkeypatch)
    n_open = 0
    for seed in range(2):
        rng = np.random.default_rng(2000 + seed)
        problems, budget = rivals(rng), float(rng.integers(1, 4))
        least = joint_optimum(problems, [1.0] * len(problems), budget)
        for limits in (Limits(0.0), Limits(nodes=0), Limits(nodes=1), Limits(nodes=3), Limits(gap=0.5)):
            joint = shared_budget(problems, budget, limits=limits)
            assert joint.bound <= least <= joint.objective, (seed, limits)
            assert not limits.gap or joint.gap <= limits.gap
            n_open += joint.objective > least
    assert n_open >= 1


@pytest.mark.parametrize("has_start", [True, False])
def test_the_proof_by_branching_is_that_of_enumeration_with_and_without_a_good_start(monkeypatch, has_start):
    if not has_start:
        without_good_trees(monkeypatch)
    n_branched = 0
    for seed in range(3):
        rng = np.random.default_rng(2000 + seed)
        problems, budget = rivals(rng), float(rng.integers(1, 4))
        joint = shared_budget(problems, budget)
        assert joint.is_optimal, seed
        assert joint.objective == joint_optimum(problems, [1.0] * len(problems), budget), seed
        n_branched += joint.n_nodes > 0
    assert n_branched >= 1


@pytest.mark.parametrize("seed", range(5))
def test_search_is_no_better_than_the_proof(seed):
    rng = np.random.default_rng(1000 + seed)
    problems = random_labels(rng, 2)
    found = shared_budget(problems, 2.0, method="search", options=SearchOptions(restarts=1))
    proven = shared_budget(problems, 2.0, method="exact")
    slack = 1e-9 * max(1.0, proven.objective)
    assert proven.objective <= found.objective + slack
    assert found.bound <= proven.objective


def gauges_for_two(n_each: int = 12) -> list[Problem]:
    """Return two labels that a shared gauge predicts well together, and two private gauges a little better one by one.

    g0 predicts all but one sample of either label; a predicts the first label wholly, b the second; c nothing.
    """
    rng = np.random.default_rng(0)
    first = rng.permutation(np.repeat([0, 1], n_each))
    second = first.copy()
    shared = first.astype(float)
    shared[0] = 1 - shared[0]
    features = np.column_stack([shared, first, second, rng.random(2 * n_each)])
    second[1] = 1 - second[1]
    features[:, 2] = second
    return [Problem(features, labels, depth=1, feature_names=("g0", "a", "b", "c")) for labels in (first, second)]


def test_a_label_says_what_it_gives_up_for_the_others():
    joint = shared_budget(gauges_for_two(), 1.0)
    assert sum(solution.bound for solution in joint.solutions) < joint.objective
    assert [solution.bound for solution in joint.solutions] == [0.0, 0.0]


def forged(joint: JointSolution) -> dict[str, JointSolution]:
    first, second = joint.solutions
    return {
        "bound": replace(joint, bound=joint.objective + 1),
        "budget": replace(joint, problems=tuple(p.replace(sensor_budget=0.5) for p in joint.problems)),
        "one budget": replace(joint, problems=(joint.problems[0], joint.problems[1].replace(sensor_budget=9.0))),
        "objective": replace(joint, solutions=(replace(first, objective=0.5), second)),
        "optimal": replace(joint, bound=joint.objective - 1),
    }


@pytest.mark.parametrize("what", ["bound", "budget", "one budget", "objective", "optimal"])
def test_the_certificate_refutes_a_forged_joint_solution(what):
    joint = shared_budget(gauges_for_two(), 1.0)
    assert sum(certificate.objective for certificate in certify_joint(joint)) == joint.objective
    with pytest.raises(CertificateError):
        certify_joint(forged(joint)[what])


def test_trees_that_together_break_the_budget_are_refuted():
    problems = gauges_for_two()
    joint = shared_budget(problems, 2.0)
    assert joint.sensors == ("a", "b")
    narrow = tuple(problem.replace(sensor_budget=1.0) for problem in joint.problems)
    with pytest.raises(CertificateError, match="together"):
        certify_joint(replace(joint, problems=narrow))


def test_wrong_input_is_named():
    problems = gauges_for_two()
    for wrong, sentence in (
        (lambda: shared_budget([], 1.0), "empty"),
        (lambda: shared_budget([problems[0].replace(sensor_budget=1.0)], 1.0), "budget of their own"),
        (lambda: shared_budget([problems[0], problems[1].replace(sensor_cost=[2, 1, 1, 1])], 1.0), "one cost"),
        (lambda: shared_budget(problems, 1.0, weights=[1.0]), "2 finite numbers"),
        (lambda: shared_budget(problems, 1.0, weights=[-1.0, 1.0]), "2 finite numbers"),
        (lambda: shared_budget(problems, -1.0), "sensor_budget"),
        (lambda: shared_budget(problems, 1.0, method="oct"), "'exact' or 'search'"),
        (lambda: shared_budget([problems[0].replace(split="hyperplane")], 1.0, method="exact"), "hyperplanes"),
    ):
        with pytest.raises(ProblemError, match=sentence):
            wrong()
