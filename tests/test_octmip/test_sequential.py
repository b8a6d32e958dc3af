"""Sequential sensing: against enumeration of every tree, and each rule by itself."""

from dataclasses import replace

import numpy as np
import pytest

from benchmarks.oracles.sequential import front
from octmip import ClassCosts, Limits, Problem, solve
from octmip.errors import CertificateError, ProblemError
from octmip.sensing import Group, SequentialProblem, certify_sequential, solve_sequential
from octmip.trees.solution import Stop
from octmip.trees.tree import Leaf, Split, leaf_index

TOLERANCE = 1e-7


def random_sequential(seed: int) -> SequentialProblem:
    """Return a small problem: ties, weights, costs, leaf sizes, shared sensors, groups, rules, by chance."""
    rng = np.random.default_rng(seed)
    n, p, k = int(rng.integers(4, 9)), int(rng.integers(1, 4)), int(rng.integers(2, 4))
    labels = np.concatenate([np.arange(k), rng.integers(0, k, n - k)])
    of_feature = [f"s{rng.integers(p)}" for _ in range(p)]
    sensors = tuple(dict.fromkeys(of_feature))
    problem = Problem(
        rng.integers(0, rng.integers(2, 6), (n, p)).astype(float),
        labels,
        depth=int(rng.integers(1, 4)),
        weights=None if rng.random() < 0.5 else rng.integers(0, 5, n) + (np.arange(n) == 0),
        loss=ClassCosts(None if rng.random() < 0.6 else rng.integers(0, 6, (k, k))),
        leaf_size=1 if rng.random() < 0.7 else int(rng.integers(1, 3)),
        leaf_penalty=0 if rng.random() < 0.7 else 1,
        sensor_of_feature=of_feature,
        sensor_cost={name: float(rng.integers(0, 4)) for name in sensors},
    )
    split = int(rng.integers(0, len(sensors) + 1))
    return SequentialProblem(
        problem,
        groups={"one": Group(sensors[:split], float(rng.integers(0, 3)))},
        within={0: int(rng.integers(0, 3))} if rng.random() < 0.4 else {},
        delay_cost={1: float(rng.integers(0, 2))} if rng.random() < 0.4 else {},
        shares=None if rng.random() < 0.6 else rng.integers(0, 4, n) + (np.arange(n) == 1),
    )


@pytest.mark.parametrize("block", range(6))
def test_every_question_has_the_answer_of_enumeration(block):
    for seed in range(block * 20, block * 20 + 20):
        sequential = random_sequential(seed)
        pairs = [(float(error), float(cost)) for error, cost in front(sequential)]
        n = sequential.problem.n_samples
        rng = np.random.default_rng(seed)
        for price in (0.0, 0.25, float(rng.random())):
            asked = replace(sequential, price=price)
            solution = solve_sequential(asked)
            found = certify_sequential(asked, solution)
            assert solution.is_optimal, seed
            assert solution.stop is Stop.OPTIMAL, seed
            best = min(pairs, key=lambda pair: (pair[0] + price * pair[1], pair[1]))
            assert found.objective == pytest.approx(best[0] + price * best[1], abs=TOLERANCE), (seed, price)
            if price == 0:
                assert found.expected_cost * n == pytest.approx(best[1], abs=TOLERANCE), seed
        for budget in {pairs[0][1] / n, 0.7 * pairs[0][1] / n, float(rng.random())}:
            asked = replace(sequential, budget=budget)
            solution = solve_sequential(asked)
            assert solution.is_optimal, (seed, budget)
            least = min(error for error, cost in pairs if cost <= budget * n + TOLERANCE)
            assert certify_sequential(asked, solution).objective == pytest.approx(least, abs=TOLERANCE), (seed, budget)


@pytest.mark.parametrize("scale", [1e-12, 0.1, 1e12])
def test_weights_of_any_size_have_the_answer_of_enumeration(scale):
    """A price that breaks ties, or a tolerance, of a fixed size would be more than all the samples together."""
    for seed in range(300, 330):
        sequential = random_sequential(seed)
        problem = replace(sequential.problem, weights=sequential.problem.weights * scale, leaf_penalty=0.0)
        asked = replace(sequential, problem=problem, delay_cost={})
        pairs = [(float(error), float(cost)) for error, cost in front(asked)]
        n = problem.n_samples
        for question in (asked, replace(asked, price=0.3 * scale), replace(asked, budget=0.7 * pairs[0][1] / n)):
            solution = solve_sequential(question)
            found = certify_sequential(question, solution)
            cap = np.inf if question.budget is None else question.budget * n + TOLERANCE
            least = min(error + question.price * cost for error, cost in pairs if cost <= cap)
            assert found.objective == pytest.approx(least, rel=1e-9, abs=1e-9 * scale), (seed, question.price)
            assert solution.bound <= least * (1 + 1e-12)
            assert solution.stop in (Stop.OPTIMAL, Stop.NUMERICS)


@pytest.mark.parametrize("method", ["search", "exact"])
def test_no_search_undercuts_enumeration_and_its_bound_holds(method):
    for seed in range(30):
        sequential = replace(random_sequential(seed), price=0.3)
        least = min(float(error) + 0.3 * float(cost) for error, cost in front(sequential))
        solution = solve_sequential(sequential, method, limits=Limits(nodes=3))
        certify_sequential(sequential, solution)
        assert solution.bound - TOLERANCE <= least <= solution.objective + TOLERANCE, seed


def wing(n: int = 200) -> Problem:
    """Return readings of six gauges, the first three alike, of four levels of damage."""
    rng = np.random.default_rng(1)
    level = rng.integers(0, 4, n)
    gauges = 100.0 * level[:, None] * np.array([1, 0.9, 0.8, 0.1, 0.1, 0.0]) + rng.normal(0, 20, (n, 6))
    return Problem(gauges, level, depth=3, feature_names=[f"g{j}" for j in range(6)])


def test_the_cheapest_of_the_optimal_trees_costs_no_more_than_the_one_found_first():
    problem = wing(100)
    best, cheapest = solve(problem), solve_sequential(SequentialProblem(problem))
    assert cheapest.objective == best.objective == best.bound
    first = certify_sequential(SequentialProblem(problem), replace(cheapest, tree=best.tree))
    assert certify_sequential(SequentialProblem(problem), cheapest).expected_cost <= first.expected_cost
    assert cheapest.details["cheapest"] == "proven"


def test_a_gauge_already_read_is_free_and_a_group_opens_once():
    tree = Split(0, 50.0, Leaf(0), Split(0, 150.0, Leaf(1), Split(1, 220.0, Leaf(2), Leaf(3))))
    sequential = SequentialProblem(wing(), groups={"root": Group(("g0", "g1"), 2.0)})
    assert [len(read) for read in sequential.read_at_leaves(tree)] == [1, 1, 2, 2]
    assert [sequential.path_cost(read) for read in sequential.read_at_leaves(tree)] == [3.0, 3.0, 4.0, 4.0]


def test_a_class_with_a_limit_is_never_told_later():
    sequential = SequentialProblem(wing(), within={3: 1})
    solution = solve_sequential(sequential)
    assert solution.is_optimal
    certify_sequential(sequential, solution)
    late = Split(3, 0.0, Leaf(0), Split(0, 150.0, Leaf(1), Leaf(3)))
    with pytest.raises(CertificateError, match="after 2 readings"):
        certify_sequential(sequential, replace(solution, tree=late))


def test_delay_cost_draws_a_class_to_the_root():
    calm, urgent = (
        solve_sequential(SequentialProblem(wing(), price=0.01, delay_cost=delay_cost)) for delay_cost in ({}, {3: 0.5})
    )

    def readings(solution):
        problem = wing()
        read = SequentialProblem(problem).read_at_leaves(solution.tree)
        reached = leaf_index(solution.tree, problem.features)[problem.codes == 3]
        return np.mean([len(read[j]) for j in reached])

    assert readings(urgent) <= readings(calm)


def test_a_changed_claim_is_refuted():
    sequential = SequentialProblem(wing(), price=0.1)
    solution = solve_sequential(sequential)
    with pytest.raises(CertificateError, match="recounted"):
        certify_sequential(sequential, replace(solution, objective=solution.objective - 1, bound=0.0, stop=Stop.TIME))
    with pytest.raises(CertificateError, match="no tree is below"):
        certify_sequential(sequential, replace(solution, bound=solution.objective + 1))
    with pytest.raises(CertificateError, match="budget"):
        certify_sequential(replace(sequential, price=0.0, budget=0.5), solution)


def test_hyperplanes_are_searched():
    problem = replace(wing(80), split="hyperplane", split_size=2, depth=2)
    sequential = SequentialProblem(problem, price=0.05)
    solution = solve_sequential(sequential)
    assert certify_sequential(sequential, solution).objective <= problem.baseline
    with pytest.raises(ProblemError, match="axis-aligned"):
        solve_sequential(sequential, "exact")


@pytest.mark.parametrize(
    ("options", "says"),
    [
        ({"price": -1.0}, "price"),
        ({"price": 1.0, "budget": 1.0}, "one of the two"),
        ({"budget": float("nan")}, "budget"),
        ({"groups": {"a": Group(("g9",), 1.0)}}, "g9"),
        ({"groups": {"a": Group(("g1",), 1.0), "b": Group(("g1",), 1.0)}}, "another group"),
        ({"within": {7: 1}}, "class 7"),
        ({"within": {3: 1.5}}, "whole number"),
        ({"delay_cost": {3: -1}}, "delay_cost"),
        ({"shares": [1.0]}, "shares"),
    ],
)
def test_what_makes_no_sequential_problem_is_refused(options, says):
    with pytest.raises(ProblemError, match=says):
        SequentialProblem(wing(), **options)


def test_a_budget_of_the_whole_tree_is_refused():
    with pytest.raises(ProblemError, match="sensor_budget"):
        SequentialProblem(replace(wing(), sensor_budget=2.0))
