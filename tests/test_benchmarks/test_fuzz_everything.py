"""The differential fuzz of every solver: a few seeds each time, and seen to find what it is there to find."""

import dataclasses
import math
from fractions import Fraction

import numpy as np
import pytest

from benchmarks.cases.fuzz.everything import SHARE, answer, complaint, questions, summary, watched
from benchmarks.oracles.enumeration import optimum
from benchmarks.oracles.rational import cost_of, least_cost
from benchmarks.oracles.wide_problems import wide_problem
from octmip import Leaf, Limits, Problem, Stop, solve

FIRST, N_SEEDS, BLOCK = 1_000_000, 240, 40


@pytest.mark.parametrize("first", range(FIRST, FIRST + N_SEEDS, BLOCK))
def test_no_solver_is_wrong_late_or_raises(first):
    for seed in range(first, first + BLOCK):
        for question, problem, least in questions(seed):
            said = answer(question, problem, least)
            assert not said["wrong"], f"{question}: {said['wrong']}"


def test_two_enumerations_agree():
    for seed in range(60):
        problem = wide_problem(np.random.default_rng([seed]), split="axis")
        assert float(least_cost(problem)) == optimum(problem).objective


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


def test_a_chunk_of_its_own_process_is_counted():
    line = watched(range(FIRST, FIRST + 2))
    assert line["n_problems"] == 2
    assert sum(line["counts"].values()) >= 2
    assert not line["wrong"]
    assert "| solver |" in summary([line])
    assert set(SHARE) == {"exact", "search", "cart", "oct", "flow", "oct_h", "benders"}


def test_limits_are_drawn_for_every_solver():
    limits = [question.limits for seed in range(30) for question, _, _ in questions(seed)]
    assert {limit.seconds < 1 for limit in limits} == {True, False}
    assert any(limit.nodes < math.inf for limit in limits)
    assert Limits(seconds=0.0) in limits
