"""A lower bound of the worst case: the cost of any tree when the sensor of its root is stuck.

A stuck sensor sends all samples to one side of the root, so the tree does what the subtree on that side does: it has
one level fewer and, where it reads sensors of the scenario, its splits part nothing. So a tree whose root reads sensor
r costs, in a scenario that has r stuck, at least the best tree of depth - 1 without the sensors of the scenario, and

    worst case  >=  min over roots r of  max over scenarios with r stuck of  optimum(depth - 1, without their sensors);

a tree without a split costs the problem's baseline. Axis-aligned trees only: a hyperplane reads other sensors beside.
"""

from dataclasses import replace

from octmip.problem import Problem
from octmip.sensing.failure.scenarios import FailureProblem, Scenario
from octmip.solution import Limits
from octmip.solver import solve


def bound_by_stuck_roots(asked: FailureProblem, limits: Limits, n_jobs: int = 1) -> float:
    """Return a lower bound of the worst objective of every tree, 0 where some root cannot be stuck.

    Parameters
    ----------
    limits
        of each of the solves, one for a scenario.
    """
    problem = asked.problem
    stuck = [scenario for scenario in asked.scenarios if scenario.fault.kind == "stuck"]
    if problem.split != "axis":
        return 0.0
    least = problem.baseline
    costs: dict[tuple[str, ...], float] = {}
    for sensor in problem.sensors:
        found = [0.0]
        for scenario in stuck:
            if sensor in scenario.sensors:
                if scenario.sensors not in costs:
                    costs[scenario.sensors] = _without(asked, scenario, limits, n_jobs)
                found.append(costs[scenario.sensors])
        least = min(least, max(found))
        if least == 0.0:
            break
    return least


def _without(asked: FailureProblem, scenario: Scenario, limits: Limits, n_jobs: int) -> float:
    """Return a lower bound of the best tree of one level fewer that reads none of the scenario's sensors."""
    problem = asked.problem
    gone = set(asked.columns(scenario).tolist())
    kept = [(j,) for j in range(problem.n_features) if j not in gone and problem.is_allowed((j,))]
    if problem.depth == 1 or not kept:
        return problem.baseline
    smaller: Problem = replace(problem, depth=problem.depth - 1, allowed_splits=kept)
    return max(0.0, solve(smaller, limits=limits, n_jobs=n_jobs).bound)
