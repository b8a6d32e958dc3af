"""The differential fuzz of every solver: a few seeds each time, and seen to find what it is there to find."""

import dataclasses
import math
from fractions import Fraction

import numpy as np
import pytest

from benchmarks.cases.fuzz.everything import results, summary, watched
from benchmarks.kinds.asked import KINDS, STREAM, answer, questions
from benchmarks.kinds.classes import complaint
from octmip import Leaf, Problem, Stop, solve
from octmip.trees.nodes.tree import n_splits
from tests.oracles.enumeration import optimum
from tests.oracles.rational import cost_of, least_cost
from tests.oracles.strategies import random_problem, with_missing
from tests.oracles.wide_problems import sized_lines, sized_problem, wide_problem

FIRST, N_SEEDS, BLOCK = 1_000_060, 120, 20
BLOCKS = [(first, kind) for first in range(FIRST, FIRST + N_SEEDS, BLOCK) for kind in KINDS]


@pytest.mark.long(*(f"{first}-{kind}" for first, kind in BLOCKS if first != FIRST or kind == "sparse_parts"))
@pytest.mark.parametrize(("first", "kind"), BLOCKS)
def test_no_solver_is_wrong_late_or_raises(first, kind):
    for seed in range(first, first + BLOCK):
        for question, problem, truth in questions(seed, (kind,)):
            said = answer(question, problem, truth)
            assert not said["wrong"], f"{question}: {said['wrong']}"


def test_two_enumerations_agree_with_missing_readings_and_with_few_splits():
    for seed in range(60):
        rng = np.random.default_rng([seed])
        for problem in (wide_problem(rng), with_missing(rng, random_problem(rng, max_samples=8))):
            best = optimum(problem)
            assert float(least_cost(problem)) == float(least_cost(few(problem, best.n_splits))) == best.objective
            assert not best.n_splits or float(least_cost(few(problem, best.n_splits - 1))) > best.objective


def drawn(draw, n):
    return [draw(np.random.default_rng([STREAM, seed])) for seed in range(n)]


def test_sizes_beyond_every_constant_of_the_core_are_drawn():
    sized = drawn(sized_problem, 100)
    assert max(problem.samples.n_samples for problem in sized) > 512
    assert max(problem.samples.n_features for problem in sized) > 5
    assert {problem.shape.depth for problem in sized} == {1, 2, 3, 4, 5}
    assert max(problem.samples.n_classes for problem in sized) > 16
    assert max(math.comb(problem.samples.n_classes, 2**problem.shape.depth) for problem in sized) > 64
    lines = drawn(sized_lines, 40)
    assert max(problem.samples.n_samples for problem in lines if problem.shape.depth == 1) > 48  # points of a dichotomy
    assert max(q.samples.n_samples for q in lines if q.shape.depth == 2) > 16  # intervals bounded together
    assert max(math.comb(problem.samples.n_samples, 2) for problem in lines) > 512  # crossings, bins of slopes
    numbers = drawn(KINDS["many_numbers"].draw, 200)
    for loss in ("squared", "absolute", "quantile"):  # bins, buckets, parts of a feature
        assert max(len(np.unique(problem.samples.targets)) for problem in numbers if problem.loss.name == loss) > 64
        assert max(len(np.unique(problem.samples.features)) for problem in numbers if problem.loss.name == loss) > 256
    near = drawn(KINDS["near"].draw, 60)
    assert max(entry.problem.samples.n_samples for entry in near) > 64


def test_every_option_of_a_problem_is_drawn():
    missing, few = drawn(KINDS["missing"].draw, 60), drawn(KINDS["few_splits"].draw, 60)
    assert any(problem.samples.n_missing and problem.shape.sensor_budget is not None for problem in missing)
    assert {problem.shape.max_splits for problem in few} == {0, 1, 2, 3}
    numbers, far = drawn(KINDS["numbers"].draw, 60), drawn(KINDS["far_numbers"].draw, 60)
    assert any(problem.shape.sensor_budget is not None for problem in numbers)
    assert any(problem.shape.leaf_size > 1 and problem.shape.leaf_penalty for problem in numbers)
    assert any(np.ptp(problem.samples.targets) > 1e9 for problem in far)


def test_random_problems_hold_every_complication():
    problems = [random_problem(np.random.default_rng(seed)) for seed in range(300)]
    assert {problem.samples.n_classes for problem in problems} == {2, 3, 4, 5, 6}
    assert {problem.shape.depth for problem in problems} == {1, 2, 3}
    for complication in (
        lambda q: q.shape.leaf_size > 1,
        lambda q: q.shape.leaf_penalty > 0,
        lambda q: q.shape.sensor_budget is not None,
        lambda q: len(q.shape.sensors) < q.samples.n_features,
        lambda q: q.shape.allowed_splits is not None,
        lambda q: q.has_integer_costs and q.samples.weights.max() > 1,
        lambda q: not q.has_integer_costs,
        lambda q: q.costs.diagonal().any(),
        lambda q: not q.samples.weights.all(),
        lambda q: any(len(np.unique(column)) == 1 for column in q.samples.features.T),
        lambda q: len(np.unique(q.samples.features, axis=0)) < q.samples.n_samples,
    ):
        assert sum(map(complication, problems)) >= 10


def test_more_splits_than_were_asked_for_are_found():
    asked = (question for seed in range(FIRST, FIRST + 900) for question in questions(seed, ("few_splits",)))
    free_of = ((p, t, solve(p.replace(max_splits=None), "exact")) for _, p, t in asked if p.shape.max_splits == 1)
    problem, truth, free = next(answer for answer in free_of if n_splits(answer[2].tree) > 1)
    said = KINDS["few_splits"].complaint(few(problem, n_splits(free.tree) - 1), free, truth, "")
    assert "but max_splits is" in said


def few(problem, most):
    """Return a problem whose trees have at most so many splits."""
    return problem.replace(max_splits=most)


def test_every_kind_of_wrong_answer_is_found():
    problem = Problem([[0.0], [1.0], [2.0], [3.0]], [0, 1, 0, 0], depth=1, weights=[1, 2, 3, 4])
    right = solve(problem)
    least = least_cost(problem)
    assert complaint(problem, right, least) == ""
    assert cost_of(problem, right.tree) == least == 1
    wrong = {
        "optimal": (dataclasses.replace(right, bound=1.0, objective=1.0), Fraction(1, 2)),
        "bound": (dataclasses.replace(right, tree=Leaf(0), objective=2.0, bound=1.0, stop=Stop.TIME), Fraction(1, 2)),
        "answer": (dataclasses.replace(right, objective=3.0, bound=-math.inf, stop=Stop.TIME), least),
    }
    for kind, (solution, truth) in wrong.items():
        assert complaint(problem, solution, truth).startswith(kind + ":")


@pytest.mark.long
def test_a_chunk_of_its_own_process_is_counted():
    (line,) = results(5.0, [1], only="^(sparse|near)", seeds=3)
    assert line["n_problems"] == 9  # three kinds, whatever the share of the seeds that each has
    assert set(line["counts"]) == {"sparse exact optimal", "sparse_parts exact optimal", "near near_optimal finished"}
    assert not line["wrong"]
    line = watched(range(FIRST, FIRST + 1))
    assert line["n_problems"] >= 1
    assert sum(line["counts"].values()) >= 1
    assert not line["wrong"]
    assert "| solver |" in summary([line])
    methods = {method for kind in KINDS.values() for method in kind.methods}
    assert methods >= {"exact", "search", "cart", "oct", "flow", "oct_h", "benders"}


def test_a_proof_that_ends_early_without_a_limit_is_found(monkeypatch):
    question, problem, truth = next(entry for seed in range(99) for entry in questions(seed, ("ties",)))
    stopped = dataclasses.replace(solve(problem, "exact"), stop=Stop.NUMERICS, bound=-math.inf)
    monkeypatch.setattr(type(KINDS["ties"]), "ask", lambda *_: stopped)
    assert answer(question, problem, truth)["wrong"].startswith("unproven")


# Calls in which the fuzz of every solver once found a fault, asked again


FOUND = [
    (2325, "oct_h", "a coefficient near the largest float64 overflowed when it was scaled"),
    (3980, "flow", "the strengthened form was written without a cut"),
    (4216, "exact", "a proof log decided a sensor that no allowed feature reads"),
    (9804, "oct_h", "an offset below the lowest float64"),
]


@pytest.mark.parametrize(("seed", "method", "what"), FOUND)
def test_what_the_fuzz_found_stays_mended(seed, method, what):
    asked = [entry for entry in questions(seed, ("axis", "hyperplane")) if entry[0].method == method]
    assert asked
    for question, problem, least in asked:
        patient = dataclasses.replace(question, limits=dataclasses.replace(question.limits, seconds=20.0))
        said = answer(patient, problem, least)
        assert not said["wrong"], f"{what}: {said['wrong']}"
