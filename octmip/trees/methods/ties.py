"""Of the optimal axis-aligned trees one of fewest splits, and of those one of fewest sensors, proven by searches."""

import math
import time
from dataclasses import dataclass, replace

import numpy as np

from octmip.trees import _native
from octmip.trees.answer.solution import Limits, Stop
from octmip.trees.encoding import CAPACITY, IntegerCosts, NodeRow, Ranks, native_problem, tree_from_rows
from octmip.trees.question.problem import Problem

UNBROKEN = {"splits": "not broken", "sensors": "not broken", "margin": "thresholds centred in their nodes"}


@dataclass(frozen=True, slots=True)
class Effort:
    """What is left for breaking ties: until when, and the limits of each search."""

    until: float
    limits: Limits
    n_jobs: int

    def search(self, native: _native.Problem, first: tuple[int, list[NodeRow]]) -> tuple[list[NodeRow], int, bool]:
        """Return table and cost of the cheapest tree (`first` where none is cheaper), and whether that is proven."""
        limits = replace(self.limits, seconds=max(0.0, self.until - time.perf_counter()), gap=0.0)
        found = _native.branch_and_bound(native, first, limits, self.n_jobs)
        return found.rows, found.objective, found.stop == Stop.OPTIMAL


def break_ties(
    problem: Problem, ranks: Ranks, costs: IntegerCosts, rows: list[NodeRow], effort: Effort
) -> tuple[list[NodeRow], dict[str, str]]:
    """Return the table of an optimal tree of fewest splits, of those one of fewest sensors, and what is proven of it.

    Every cost is multiplied by more than the splits that a tree can have, and a split costs one more: the cheapest tree
    of that problem is a cheapest one of this, and has the fewest splits of those.
    """
    factor = min(2**problem.shape.depth, problem.samples.n_samples)
    finer = replace(costs, costs=costs.costs * factor, penalty=costs.penalty * factor + 1)
    largest = float(finer.weights.sum()) * float(finer.costs.max()) + finer.penalty * factor
    if largest >= CAPACITY:
        return rows, UNBROKEN | {"splits": "not broken: the costs are too fine to count splits beside them"}
    cost = finer.whole_objective(problem, tree_from_rows(rows, ranks))
    rows, cost, is_proven = effort.search(native_problem(problem, ranks, finer), (cost, rows))
    if not is_proven:
        return rows, UNBROKEN | {"splits": "fewer looked for, not proven"}
    rows, said = _fewest_sensors(problem, ranks, finer, (cost, rows), effort)
    return rows, UNBROKEN | {"splits": "fewest, proven", "sensors": said}


def _fewest_sensors(
    problem: Problem, ranks: Ranks, costs: IntegerCosts, best: tuple[int, list[NodeRow]], effort: Effort
) -> tuple[list[NodeRow], str]:
    """Return the table of a tree no costlier than `best` of the fewest sensors, and what is proven of it.

    One sensor fewer at a time, as a budget, until no tree within it is as cheap: none of still fewer is, as cost never
    falls when sensors are taken away.
    """
    shape = problem.shape
    cost, rows = best
    is_bound = math.fsum(shape.sensor_costs) > shape.sensor_limit
    if is_bound and np.ptp(shape.sensor_costs) > 0:
        return rows, "not broken: a budget of sensors of different cost is kept"
    while n_sensors := len(shape.sensors_used(tree_from_rows(rows, ranks))):
        fewer = problem.replace(sensor_cost=[1.0] * len(shape.sensors), sensor_budget=float(n_sensors - 1))
        leaf: NodeRow = {"label": 0}
        # Stands for "a tree that costs one more": what comes back in its place is as cheap as `best`.
        found, least, is_proven = effort.search(native_problem(fewer, ranks, costs), (cost + 1, [leaf]))
        if least <= cost:
            rows = found
        elif is_proven:
            break
        else:
            return rows, "fewer looked for, not proven"
    return rows, "fewest, proven"
