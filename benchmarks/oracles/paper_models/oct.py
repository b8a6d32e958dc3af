"""OCT as a Pyomo model; table of letters, equations and departures from print in `octmip.trees.mip.oct`."""

from typing import Any

import pyomo.environ as pyo

from benchmarks.oracles.paper_models.leaves import add_leaves
from benchmarks.oracles.paper_models.limits import add_limits
from octmip.trees.encoding import rank_features
from octmip.trees.mip.blocks import axis
from octmip.trees.mip.blocks.heap import Heap
from octmip.trees.mip.oct import scaled_features
from octmip.trees.problem import Problem
from octmip.trees.problem_values import refuse_missing


def paper_model(problem: Problem, *, closed: bool = True, max_splits: int | None = None) -> Any:
    """Return OCT as a Pyomo ConcreteModel that reads as on paper; the letters are those of `octmip.trees.mip.oct`."""
    refuse_missing(problem.n_missing, "the paper's model has no side for them", "fill them in")
    ranks, heap = rank_features(problem), Heap(problem.depth)
    x, eps = scaled_features(ranks)
    usable = set(axis.usable_features(problem, ranks))
    eps_max, shift = eps.max(), eps.min() if closed else 0.0
    T_B, T_L, samples, J = heap.branches, heap.leaves, range(problem.n_samples), range(problem.n_features)

    M = pyo.ConcreteModel("OCT")
    M.a = pyo.Var(J, T_B, domain=pyo.Binary, bounds=lambda _, j, t: (0, int(j in usable)))
    M.b = pyo.Var(T_B, bounds=(0, 1))
    M.d = pyo.Var(T_B, domain=pyo.Binary)
    cost = add_leaves(M, problem, heap)
    M.cost = pyo.Objective(expr=cost + problem.leaf_penalty * sum(M.d.values()))
    M.one_feature = pyo.Constraint(T_B, rule=lambda M, t: sum(M.a[j, t] for j in J) == M.d[t])
    M.threshold = pyo.Constraint(T_B, rule=lambda M, t: M.b[t] <= M.d[t])
    M.parent_splits = pyo.Constraint(T_B[1:], rule=lambda M, t: M.d[t] <= M.d[t // 2])
    right = [(i, m, t) for t in T_L for m in heap.right_ancestors(t) for i in samples]
    left = [(i, m, t) for t in T_L for m in heap.left_ancestors(t) for i in samples]
    M.right = pyo.Constraint(
        right, rule=lambda M, i, m, t: sum(M.a[j, m] * x[i, j] for j in J) >= M.b[m] - (1 - M.z[i, t])
    )
    M.left = pyo.Constraint(
        left,
        rule=lambda M, i, m, t: (
            sum(M.a[j, m] * (x[i, j] + eps[j] - shift) for j in J) + shift <= M.b[m] + (1 + eps_max) * (1 - M.z[i, t])
        ),
    )
    add_limits(M, problem, M.a, None if max_splits is None else (sum(M.d.values()), max_splits))
    return M
