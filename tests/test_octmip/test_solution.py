"""Solutions and limits: derived numbers agree with the claims they derive from."""

import dataclasses
import math

import pytest

from octmip import Leaf, Limits, Solution, Stop
from octmip.errors import ProblemError, SolverError
from octmip.solution import relative_gap


def solution(objective=10.0, bound=8.0, tree=Leaf(0), **changes):  # noqa: B008 (frozen)
    return Solution(tree, objective, bound, Stop.TIME, 1.0, 5, "exact", "1", 0, **changes)


def test_the_gap_is_relative_to_the_objective():
    assert solution().gap == pytest.approx(0.2)
    assert not solution().is_optimal
    assert solution(bound=-math.inf).gap == math.inf
    assert solution(objective=0.0, bound=0.0).gap == 0
    assert solution(objective=0.0, bound=0.0).is_optimal


def test_a_bound_within_the_tolerance_meets_the_objective():
    assert not solution(bound=9.9999).is_optimal
    within = solution(bound=9.9999, tolerance=0.001)
    assert within.is_optimal
    assert within.gap == 0


def test_without_a_tree_there_is_no_optimum():
    nothing = solution(objective=math.inf, bound=3.0, tree=None)
    assert nothing.gap == math.inf
    assert not nothing.is_optimal


@pytest.mark.parametrize(
    ("objective", "bound", "gap"),
    [(10, 10, 0), (10, 12, 0), (10, 5, 0.5), (math.inf, 1, math.inf), (1, -math.inf, math.inf), (0, -1, math.inf)],
)
def test_relative_gap(objective, bound, gap):
    assert relative_gap(objective, bound) == gap or (gap == math.inf and relative_gap(objective, bound) > 1e9)


@pytest.mark.parametrize(
    ("changes", "sentence"),
    [
        ({"objective": math.nan}, "NaN is no proof"),
        ({"bound": math.nan}, "NaN is no proof"),
        ({"objective": math.inf}, "expected \\+inf iff none"),
        ({"tree": None}, "expected \\+inf iff none"),
    ],
)
def test_claims_that_cannot_be_are_refused(changes, sentence):
    with pytest.raises(SolverError, match=sentence):
        solution(**changes)


@pytest.mark.parametrize("name", ["seconds", "gap", "nodes", "memory"])
@pytest.mark.parametrize("value", [-1.0, math.nan])
def test_a_negative_limit_is_refused(name, value):
    with pytest.raises(ProblemError, match=f"limit {name} is"):
        Limits(**{name: value})


def test_a_solution_cannot_be_changed():
    with pytest.raises(dataclasses.FrozenInstanceError):
        solution().objective = 0.0
