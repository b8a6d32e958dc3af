"""The baseline split: a budget divided between the labels, each label's tree found by itself.

    min over b_1 + ... + b_L <= budget  of  sum_l weight_l z_l(b_l)

with z_l(b) from the frontier of label l over its budget, by dynamic programming over labels. The budgets that are
tried: multiples of the largest number of which all sensor costs are multiples, where that makes `MOST_STEPS` or fewer,
so that no other split is better; else `MOST_STEPS` equal steps.
"""

import math
from collections.abc import Sequence
from dataclasses import replace

from octmip.sensing.shared.label_trees import LabelTrees
from octmip.sensing.shared.solution import BaselineSplit, weighted_sum
from octmip.trees.problem import Problem
from octmip.trees.solution import Stop
from octmip.trees.tradeoff import Point
from octmip.trees.tradeoff.frontier import frontier_run
from octmip.trees.tree import Node

MOST_STEPS = 12


def best_baseline_split(labels: LabelTrees, budget: float) -> BaselineSplit:
    """Return the best baseline split; its trees are offered to `labels`.

    Where time runs out before every label's frontier is there, the labels that lack one get a leaf.
    """
    budgets = budget_steps(labels.problems, budget)
    n_points = len(budgets) * len(labels.problems)
    frontiers = [_frontier(labels, problem, budgets, n_points) for problem in labels.problems]
    return _best_split(labels, frontiers, budgets)


def _frontier(labels: LabelTrees, problem: Problem, budgets: Sequence[float], n_points: int) -> list[Point]:
    if labels.is_over:
        return []
    seconds = labels.run.limits.seconds / (2 * n_points)  # half of the time is for what comes after
    run = replace(labels.run, limits=replace(labels.remaining, seconds=seconds))
    points = frontier_run(problem, "budget", budgets, run)
    labels.is_interrupted |= any(point.solution.stop is Stop.INTERRUPTED for point in points)
    return points


def budget_steps(problems: Sequence[Problem], budget: float) -> tuple[float, ...]:
    """Return the budgets that are tried for one label, ascending, the whole one included."""
    costs = sorted({float(cost) for problem in problems for cost in problem.sensor_costs if cost > 0})
    if costs and all(cost == math.floor(cost) for cost in costs):
        step = math.gcd(*(int(cost) for cost in costs))
        if 1 <= budget / step <= MOST_STEPS:
            return (*(float(step * k) for k in range(1, int(budget / step) + 1)),)
    return tuple(budget * k / MOST_STEPS for k in range(1, MOST_STEPS + 1)) if budget > 0 else (0.0,)


def _best_split(labels: LabelTrees, frontiers: Sequence[Sequence[Point]], budgets: Sequence[float]) -> BaselineSplit:
    """Return the best way to share out the steps; step k stands for budgets[k - 1], step 0 for a leaf."""
    n_steps = len(budgets)
    # plans[k]: the least weighted sum for k steps among the labels so far, and what each of them gets
    plans: list[tuple[float, tuple[int, ...]]] = [(0.0, ())] * (n_steps + 1)
    for weight, problem, points in zip(labels.weights, labels.problems, frontiers, strict=True):
        value = [problem.baseline, *(point.solution.objective for point in points)]
        plans = [
            min((plans[k - j][0] + weight * value[j], (*plans[k - j][1], j)) for j in range(min(k + 1, len(value))))
            for k in range(n_steps + 1)
        ]
    steps = plans[-1][1]
    labels.offer(
        [_tree(labels, k, points, step) for k, (points, step) in enumerate(zip(frontiers, steps, strict=True))]
    )
    values = [
        points[step - 1].solution.objective if step else problem.baseline
        for problem, points, step in zip(labels.problems, frontiers, steps, strict=True)
    ]
    spent = tuple(budgets[step - 1] if step else 0.0 for step in steps)
    return BaselineSplit(spent, weighted_sum(labels.weights, values))


def _tree(labels: LabelTrees, label: int, points: Sequence[Point], step: int) -> Node:
    tree = points[step - 1].solution.tree if step else None
    return tree if tree is not None else labels.leaf(label)
