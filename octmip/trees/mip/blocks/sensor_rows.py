"""Sensor rows: the sensor budget, which Bertsimas & Dunn lack, as columns and rows."""

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from octmip.trees.mip.blocks.heap import Placed
from octmip.trees.mip.rows import Rows
from octmip.trees.question.problem import Problem


def add_sensor_rows(rows: Rows, problem: Problem, uses: Sequence[Mapping[int, int]]) -> None:
    """Add u_s = 1 if sensor s is read: u_s >= uses[t][j] for each of its features, sum_s cost_s u_s <= budget.

    `uses`: for each branch node, by feature, the column that is 1 where its split reads that feature. Nothing is added
    without a budget.
    """
    if problem.shape.sensor_budget is None:
        return
    u = rows.columns("u", (range(len(problem.shape.sensors)),), integer=True)
    pairs = np.array([(u[problem.shape.sensor_index[j]], column) for node in uses for j, column in node.items()])
    if len(pairs):
        rows.add("sensor_read", 0, np.inf, (pairs[:, [0]], 1.0), (pairs[:, [1]], -1.0))
    rows.add("sensor_budget", -np.inf, 1.0, (u, budget_shares(problem)))


def budget_shares(problem: Problem) -> NDArray[np.float64]:
    """Return each sensor's share of the budget, 2 where it alone exceeds it: numbers near 1 in any unit of cost."""
    limit = problem.shape.sensor_limit
    return np.asarray(np.minimum(problem.shape.sensor_costs, 2 * limit) / limit)


def set_sensors(values: NDArray[np.float64], rows: Rows, problem: Problem, placed: Placed) -> None:
    """Write the sensors that a tree laid into the heap reads into `values` (n_columns,)."""
    if "u" in rows.families:
        u = rows.families["u"][0]
        for split in placed.splits.values():
            values[u[problem.shape.sensor_index[list(split.features)]]] = 1
