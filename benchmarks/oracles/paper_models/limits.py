"""Sensor budget and number of splits as Pyomo constraints: the rows of `octmip.trees.mip.blocks.sensor_rows`."""

from typing import Any

import pyomo.environ as pyo

from octmip.trees.mip.blocks.sensor_rows import budget_shares
from octmip.trees.problem import Problem


def add_limits(M: Any, problem: Problem, uses: Any, splits: tuple[Any, int] | None) -> None:
    """Add the sensor budget to a Pyomo model, and that the first of `splits` is at most the second."""
    if splits is not None:
        M.max_splits = pyo.Constraint(expr=splits[0] <= splits[1])
    if problem.sensor_budget is not None:
        owner, share = problem.sensor_index, budget_shares(problem)
        M.u = pyo.Var(range(len(problem.sensors)), domain=pyo.Binary)
        M.sensor_read = pyo.Constraint(uses.index_set(), rule=lambda M, j, t: M.u[owner[j]] >= uses[j, t])
        M.sensor_budget = pyo.Constraint(expr=sum(c * M.u[s] for s, c in enumerate(share)) <= 1)
