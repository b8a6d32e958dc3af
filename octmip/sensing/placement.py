"""Placement: the few of many possible sensors that the best tree reads.

    minimise   the objective of the tree
    over       trees of the problem whose sensors cost the budget at most

Every split of a tree names its sensors, so the best tree over all candidates *is* a placement: a combination of sensors
chosen for what they tell together, where a rule of thumb ranks them one by one. `placement_frontier` gives the value
of each further sensor, `placement_on` the best tree of another choice of sensors.

Bounds. Axis-aligned trees are proven by the exact core over all sets of sensors. For hyperplanes a bound of a wider
problem serves: whatever the sensors, a tree of depth d predicts 2^d classes at most (`label_bound`). It is not tight
where a tree has leaves enough for all classes.
"""

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from itertools import combinations
from typing import Any, Literal

import numpy as np

from octmip.errors import ProblemError
from octmip.trees.answer.solution import Limits, Solution, Stop
from octmip.trees.encoding.costs import exact_sum, rounded_down
from octmip.trees.methods.options import NO_OPTIONS, Options
from octmip.trees.nodes.tree import Leaf, Node, Split
from octmip.trees.question.problem import Problem
from octmip.trees.runs.registry import Method, Run
from octmip.trees.solver import solve_run
from octmip.trees.tradeoff import Point
from octmip.trees.tradeoff.frontier import frontier_run

MOST_LABEL_SETS = 20_000  # of which label_bound tries each


@dataclass(frozen=True, slots=True, eq=False)
class Placement:
    """Sensors that were chosen, and the tree that reads them.

    Attributes
    ----------
    sensors
        names of the sensors that are installed, in the order of the candidates.
    cost
        of those sensors.
    problem
        the problem with the features of those sensors alone, or of all candidates where the tree chose.
    solution
        its tree, in the features of `problem`.

    Examples
    --------
    >>> problem = Problem([[0, 5], [1, 5], [2, 7]], ["a", "b", "b"], depth=1, feature_names=["g1", "g2"])
    >>> placement = place_sensors(problem)
    >>> placement.cost, placement.solution.objective
    (1.0, 0.0)
    """

    sensors: tuple[str, ...]
    cost: float
    problem: Problem
    solution: Solution


def place_sensors(
    problem: Problem,
    *,
    starts: Iterable[Iterable[str]] = (),
    method: Method = "auto",
    limits: Limits = Limits(),  # noqa: B008 (frozen)
    seed: int = 0,
    n_jobs: int = 1,
    options: Options = NO_OPTIONS,
) -> Placement:
    """Return the sensors that the best tree over all candidates reads, within `problem.sensor_budget` if it has one.

    Parameters
    ----------
    problem
        its features are those of all candidates.
    starts
        sets of sensors within the budget, for instance chosen as in `octmip.sensing.designs`. Their trees are
        found first, and the search over all candidates begins at the best of them: so it is never worse than any of
        them, which a search by itself does not promise.
    method, limits, seed, n_jobs, options
        of each solve, see `octmip.solve`.

    Raises
    ------
    ProblemError
        a start names a sensor that is not there, or breaks the budget.
    SolverError
        a solver failed.

    Examples
    --------
    >>> problem = Problem([[0, 5], [1, 5], [2, 7]], ["a", "b", "b"], depth=1, feature_names=["g1", "g2"])
    >>> place_sensors(problem).sensors
    ('g1',)
    """
    run = Run(method, limits, seed, n_jobs, options)
    known = [_placement_on(problem, sensors, run) for sensors in starts]
    known = [placement for placement in known if placement.solution.tree is not None]
    best = min(known, key=lambda placement: placement.solution.objective, default=None)
    first = None if best is None else _among_all(best, problem)
    solution = solve_run(problem, run, first)
    if solution.tree is None:
        return Placement((), 0.0, problem, solution)
    sensors = problem.shape.sensors_used(solution.tree)
    return Placement(sensors, problem.shape.sensor_cost_of(solution.tree), problem, solution)


def _among_all(placement: Placement, problem: Problem) -> Node:
    """Return the tree of a placement on some sensors, its features those of the problem with all."""
    index = [problem.samples.feature_names.index(name) for name in placement.problem.samples.feature_names]

    def renamed(tree: Node) -> Node:
        if isinstance(tree, Leaf):
            return tree
        left, right = renamed(tree.left), renamed(tree.right)
        if isinstance(tree, Split):
            return replace(tree, feature=index[tree.feature], left=left, right=right)
        return replace(tree, features=tuple(index[j] for j in tree.features), left=left, right=right)

    return renamed(placement.solution.tree)


def placement_on(
    problem: Problem,
    sensors: Iterable[str],
    *,
    method: Method = "auto",
    limits: Limits = Limits(),  # noqa: B008 (frozen)
    seed: int = 0,
    n_jobs: int = 1,
    options: Options = NO_OPTIONS,
) -> Placement:
    """Return these sensors with the best tree that reads no others; the other args are those of `octmip.solve`.

    Raises
    ------
    ProblemError
        a sensor is not one of the problem's, or there is none.
    SolverError
        as `octmip.solve`.

    Examples
    --------
    >>> problem = Problem([[0, 5], [1, 5], [2, 7]], ["a", "b", "b"], depth=1, feature_names=["g1", "g2"])
    >>> placement_on(problem, ["g2"]).solution.objective
    1.0
    """
    return _placement_on(problem, sensors, Run(method, limits, seed, n_jobs, options))


def _placement_on(problem: Problem, sensors: Iterable[str], run: Run) -> Placement:
    part = problem_on(problem, sensors)
    return Placement(part.shape.sensors, math.fsum(part.shape.sensor_costs), part, solve_run(part, run))


def problem_on(problem: Problem, sensors: Iterable[str]) -> Problem:
    """Return the problem with the features of some sensors alone.

    Raises
    ------
    ProblemError
        a sensor is not one of the problem's, or there is none.
    """
    shape = problem.shape
    wanted = set(sensors)
    unknown = sorted(wanted - set(shape.sensors))
    if unknown or not wanted:
        raise ProblemError(f"sensors names {unknown or 'none'}; expected some of the problem's {len(shape.sensors)}")
    assert shape.sensor_of_feature is not None  # filled in by Problem
    kept = [j for j, name in enumerate(shape.sensor_of_feature) if name in wanted]
    groups: Any = shape.allowed_splits
    if groups is not None:
        groups = [[kept.index(j) for j in group if j in kept] for group in groups]
        groups = [group for group in groups if group]
    costs = dict(zip(shape.sensors, shape.sensor_costs.tolist(), strict=True))
    return problem.replace(
        features=problem.samples.features[:, kept],
        feature_names=tuple(problem.samples.feature_names[j] for j in kept),
        sensor_of_feature=[shape.sensor_of_feature[j] for j in kept],
        sensor_cost={name: cost for name, cost in costs.items() if name in wanted},
        allowed_splits=groups,
    )


def placement_frontier(
    problem: Problem,
    over: Literal["number", "cost"] = "number",
    values: Sequence[float] | None = None,
    *,
    method: Method = "auto",
    limits: Limits = Limits(),  # noqa: B008 (frozen)
    seed: int = 0,
    n_jobs: int = 1,
    options: Options = NO_OPTIONS,
) -> list[Point]:
    """Return the best tree for each number of sensors, or for each cost that they may have together.

    Parameters
    ----------
    problem
        its `sensor_budget` is not used.
    over
        "number": every sensor counts 1; "cost": the problem's sensor costs.
    values
        numbers or costs; None: 1, 2, ... to as many as a tree of this depth can read.
    method, limits, seed, n_jobs, options
        of each solve, see `octmip.solve`.

    Returns
    -------
    One point a value, ascending; the bound of each is the best of its solver's, of the wider points' and of
    `label_bound`.

    Raises
    ------
    ProblemError
        costs differ and no values are given, or a value makes no problem.
    SolverError
        as `octmip.solve`.

    Examples
    --------
    >>> problem = Problem([[0, 5], [1, 5], [2, 7]], ["a", "b", "b"], depth=1, feature_names=["g1", "g2"])
    >>> [(point.value, point.solution.objective) for point in placement_frontier(problem)]
    [(1, 0.0)]
    """
    counted = problem.replace(sensor_cost=None) if over == "number" else problem
    points = frontier_run(counted, "budget", values, Run(method, limits, seed, n_jobs, options))
    known = label_bound(problem)
    return [replace(point, solution=_bounded(point.solution, known)) for point in points]


def _bounded(solution: Solution, bound: float) -> Solution:
    if bound <= solution.bound or solution.tree is None:
        return solution
    better = replace(solution, bound=min(bound, solution.objective))
    return replace(better, stop=Stop.OPTIMAL) if better.meets_bound else better


def label_bound(problem: Problem) -> float:
    """Return a lower bound of every tree of the problem's depth, which predicts 2^depth classes at most.

    The least cost over the sets of so many classes when every sample gets the cheapest class of the set; 0 or more.

    >>> label_bound(Problem([[0], [1], [2]], ["a", "b", "c"], depth=1))  # two leaves, three classes
    1.0
    """
    n_leaves, n_classes = 2**problem.shape.depth, problem.samples.n_classes
    paid = [exact_sum(problem.samples.weights[problem.samples.codes == code]) for code in range(n_classes)]
    size = min(n_leaves, n_classes)
    if math.comb(n_classes, size) > MOST_LABEL_SETS:
        return 0.0
    rounded = np.array([float(weight) for weight in paid])
    sets = [list(chosen) for chosen in combinations(range(n_classes), size)]
    least = np.array([rounded @ problem.costs[:, chosen].min(axis=1) for chosen in sets])
    # Only sets that are cheapest but for rounding are added up exactly: there may be thousands.
    near = [chosen for chosen, cost in zip(sets, least.tolist(), strict=True) if cost <= least.min() * (1 + 1e-9)]
    prices = ([Fraction(price) for price in problem.costs[:, chosen].min(axis=1).tolist()] for chosen in near)
    sums = (sum((w * c for w, c in zip(paid, row, strict=True)), Fraction(0)) for row in prices)
    return rounded_down(min(sums))
