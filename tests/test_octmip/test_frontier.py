"""Frontiers: each point is the optimum of its own problem, and neither objectives nor bounds go the wrong way."""

import math

import numpy as np
import pytest

from octmip import Leaf, Limits, Problem, Solution, Stop, certify, solve
from octmip.errors import ProblemError
from octmip.trees.tradeoff.frontier import Point, _with_bounds_of_wider_limits, default_values, trace_frontier
from octmip.trees.tradeoff.path import trace_path

RNG = np.random.default_rng(3)
FEATURES = RNG.normal(size=(40, 3)).round(1)
LABELS = (FEATURES[:, 0] + 0.5 * FEATURES[:, 1] > 0).astype(int) + (FEATURES[:, 2] > 0.8)
PROBLEM = Problem(FEATURES, LABELS, depth=3)


@pytest.mark.parametrize("over", ["depth", "budget", "penalty"])
def test_every_point_is_the_optimum_of_its_own_problem(over):
    points = trace_frontier(PROBLEM, over)
    if over == "penalty":
        assert [point.value for point in points] == [best.penalty for best in trace_path(PROBLEM).trees]
    else:
        assert [point.value for point in points] == list(default_values(PROBLEM, over))
    for point in points:
        certify(point.problem, point.solution)
        assert point.solution.is_optimal
        assert point.solution.objective == solve(point.problem).objective


def test_a_bound_of_a_wider_limit_serves_the_tighter_ones():
    def point(value, objective, bound, stop=Stop.TIME):
        solution = Solution(Leaf(0), objective, bound, stop, 0.0, 0, "exact", "1", 0)
        return Point(value, PROBLEM, solution)

    points = [point(1, 9.0, -math.inf), point(2, 7.0, 7.0, Stop.OPTIMAL), point(3, 5.0, 2.0), point(4, 4.0, 3.0)]
    after = [p.solution for p in _with_bounds_of_wider_limits(points)]
    assert [s.bound for s in after] == [7.0, 7.0, 3.0, 3.0]
    same = _with_bounds_of_wider_limits([point(1, 7.0, 1.0), point(2, 7.0, 7.0, Stop.OPTIMAL)])[0].solution
    assert same.is_optimal
    assert same.stop is Stop.OPTIMAL


def test_a_bound_that_is_taken_over_never_exceeds_the_tree_of_its_point():
    """Sums of two problems are rounded each for itself: the wider bound may lie above the tighter tree by a hair."""
    above = math.nextafter(7.0, 8.0)
    tight = Solution(Leaf(0), 7.0, 1.0, Stop.TIME, 0.0, 0, "exact", "1", 0)
    wide = Solution(Leaf(0), above, above, Stop.OPTIMAL, 0.0, 0, "exact", "1", 0)
    after = _with_bounds_of_wider_limits([Point(1, PROBLEM, tight), Point(2, PROBLEM, wide)])
    assert [point.solution.bound for point in after] == [7.0, above]
    assert after[0].solution.stop is Stop.OPTIMAL


def test_values_are_taken_in_order_whatever_order_they_come_in():
    points = trace_frontier(PROBLEM, "depth", [2, 1], method="cart", limits=Limits(seconds=10))
    assert [point.problem.shape.depth for point in points] == [1, 2]


@pytest.mark.parametrize(
    ("over", "values", "sentence"),
    [("depth", [1.5], r"depth is 1\.5"), ("budget", [-1], "sensor_budget is -1"), ("width", None, "over is 'width'")],
)
def test_a_value_that_makes_no_problem_is_refused(over, values, sentence):
    with pytest.raises(ProblemError, match=sentence):
        trace_frontier(PROBLEM, over, values, method="cart")


def test_budgets_must_be_named_where_sensors_differ_in_cost():
    expensive = PROBLEM.replace(sensor_cost=[1, 2, 5])
    with pytest.raises(ProblemError, match="name the values"):
        trace_frontier(expensive, "budget")
    assert len(trace_frontier(expensive, "budget", [2, 3], method="cart")) == 2


def test_penalties_have_no_default_values_without_their_path():
    with pytest.raises(ProblemError, match="over is 'penalty'; expected depth or budget"):
        default_values(PROBLEM, "penalty")
