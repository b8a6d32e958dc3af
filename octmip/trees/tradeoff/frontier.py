"""Frontiers: the least cost against depth, sensor budget or leaf penalty, one proof after the other.

A tree that meets a tight limit meets a wide one too. So each point starts from the tree of the point before, and a
bound proven under a wide limit holds under every tighter one: along a frontier of depth or budget objectives never rise
and bounds never fall behind. A frontier over the penalty has one point for each tree that is best for some penalty
(octmip.trees.tradeoff.path), in the middle of its interval.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal

from octmip.errors import ProblemError
from octmip.trees.answer.solution import Limits, ProgressCallback, Solution, Stop
from octmip.trees.methods.options import NO_OPTIONS, Options
from octmip.trees.nodes.tree import Node
from octmip.trees.question.problem import Problem
from octmip.trees.runs.registry import Method, Run
from octmip.trees.solver import solve_run
from octmip.trees.tradeoff.path import trace_run

Over = Literal["depth", "budget", "penalty"]
OVERS: tuple[Over, ...] = ("depth", "budget", "penalty")


@dataclass(frozen=True, slots=True)
class Point:
    """One point: the value that is varied, the problem with it, and its solution."""

    value: float
    problem: Problem
    solution: Solution


def default_values(problem: Problem, over: Literal["depth", "budget"]) -> tuple[float, ...]:
    """Return the values that a frontier takes when none are given.

    Depths from 1 to the problem's; as many sensors as a tree of its depth can read, where each costs 1.

    Raises
    ------
    ProblemError
        sensors have other costs, so that budgets must be named; or `over` is neither of the two.
    """
    shape = problem.shape
    if over == "depth":
        return tuple(range(1, shape.depth + 1))
    if over != "budget":
        raise ProblemError(f"over is {over!r}; expected depth or budget; penalties of interest come from trace_path")
    if (shape.sensor_costs != 1).any():
        raise ProblemError("sensors do not cost 1 each, so the budgets of interest are not 1, 2, ...; name the values")
    readable = (2**shape.depth - 1) * shape.max_split_size
    return tuple(range(1, min(len(shape.sensors), readable) + 1))


def trace_frontier(
    problem: Problem,
    over: Over,
    values: Sequence[float] | None = None,
    *,
    method: Method = "auto",
    limits: Limits = Limits(),  # noqa: B008 (frozen)
    seed: int = 0,
    n_jobs: int = 1,
    progress: ProgressCallback | None = None,
    options: Options = NO_OPTIONS,
) -> list[Point]:
    """Return one point for each value, values ascending; `limits` hold for each point by itself.

    Ctrl-C ends the frontier: the points so far come back, the last one interrupted. Without values the penalties are
    those at which another tree is best, which takes about two more solves per point. `options` are the method's own,
    for instance ``restarts`` of the search, or ``cluster``: each solve is then shared by its workers, one solve after
    the other.

    Raises
    ------
    ProblemError
        `over` is unknown, or a value makes no problem.
    """
    return frontier_run(problem, over, values, Run(method, limits, seed, n_jobs, options, progress))


def frontier_run(problem: Problem, over: Over, values: Sequence[float] | None, run: Run) -> list[Point]:
    """Return what `trace_frontier` returns for the method, limits, seed, threads, options and progress of a run.

    Raises
    ------
    ProblemError
        as `trace_frontier`.
    """
    if over not in OVERS:
        raise ProblemError(f"over is {over!r}; expected one of {', '.join(OVERS)}")
    with run.options.of_study().opened(run.n_jobs) as options:
        points = _points(problem, over, values, replace(run, options=options))
    return points if over == "penalty" else _with_bounds_of_wider_limits(points)


def _points(problem: Problem, over: Over, values: Sequence[float] | None, run: Run) -> list[Point]:
    points: list[Point] = []
    for value, tree in _starts(problem, over, values, run):
        here = _problem_at(problem, over, value)
        known = tree or (points[-1].solution.tree if points else None)
        solution = solve_run(here, run, known)
        points.append(Point(value, here, solution))
        if solution.stop is Stop.INTERRUPTED:
            break
    return points


def _starts(problem: Problem, over: Over, values: Sequence[float] | None, run: Run) -> list[tuple[float, Node | None]]:
    """Return the values, ascending, each with a tree to start from where one is known beforehand."""
    if over == "penalty" and values is None:
        path = trace_run(problem, run)
        return [(best.penalty, best.tree) for best in path.trees]
    chosen = default_values(problem, over) if values is None and over != "penalty" else values
    assert chosen is not None
    return [(value, None) for value in sorted(chosen)]


def _problem_at(problem: Problem, over: Over, value: float) -> Problem:
    if over == "depth":
        return problem.replace(depth=int(value) if value == math.floor(value) else value)
    return problem.replace(sensor_budget=value) if over == "budget" else problem.replace(leaf_penalty=value)


def _with_bounds_of_wider_limits(points: Sequence[Point]) -> list[Point]:
    """Return the points with each bound at least that of every wider limit, which allows all its trees and more."""
    best, out = -math.inf, []
    for point in reversed(points):
        best = max(best, point.solution.bound)
        out.append(replace(point, solution=point.solution.with_bound(best)))
    return out[::-1]
