"""OCT-H as a Pyomo model; table of letters and what the printed form does not say in `octmip.trees.mip.oct_h`."""

from typing import Any

import pyomo.environ as pyo

from benchmarks.oracles.paper_models.leaves import add_leaves
from benchmarks.oracles.paper_models.limits import add_limits
from octmip.trees.mip.blocks.heap import Heap
from octmip.trees.mip.blocks.hyperplanes import space_of, usable_features
from octmip.trees.problem import Problem
from octmip.trees.problem_values import refuse_missing


def paper_model(problem: Problem, mu: float, *, max_splits: int | None = None) -> Any:
    """Return OCT-H as a Pyomo ConcreteModel that reads as on paper; the letters are those of `mip.oct_h`."""
    refuse_missing(problem.n_missing, "hyperplanes add readings", "fill them in")
    space, heap = space_of(problem, centred=False), Heap(problem.depth)
    usable, reach, largest = usable_features(problem), space.reach, space.coefficient
    T_B, T_L, samples, J = heap.branches, heap.leaves, range(problem.n_samples), range(problem.n_features)
    x = space.x

    M = pyo.ConcreteModel("OCT-H")
    whole = pyo.Integers if space.is_integer else pyo.Reals
    M.a = pyo.Var(J, T_B, domain=whole, bounds=lambda _, j, t: (-largest * usable[j], largest * usable[j]))
    M.s = pyo.Var(J, T_B, domain=pyo.Binary, bounds=lambda _, j, t: (0, int(usable[j])))
    M.b = pyo.Var(T_B, bounds=(-reach, reach))
    M.d = pyo.Var(T_B, domain=pyo.Binary)
    cost = add_leaves(M, problem, heap)
    M.cost = pyo.Objective(expr=cost + problem.leaf_penalty * sum(M.s.values()))
    if not space.is_integer:
        M.a_hat = pyo.Var(J, T_B, bounds=(0, 1))
        M.size_above = pyo.Constraint(J, T_B, rule=lambda M, j, t: M.a_hat[j, t] >= M.a[j, t])
        M.size_below = pyo.Constraint(J, T_B, rule=lambda M, j, t: M.a_hat[j, t] >= -M.a[j, t])
        M.normal_size = pyo.Constraint(T_B, rule=lambda M, t: sum(M.a_hat[j, t] for j in J) <= M.d[t])
    M.read_above = pyo.Constraint(J, T_B, rule=lambda M, j, t: M.a[j, t] <= largest * M.s[j, t])
    M.read_below = pyo.Constraint(J, T_B, rule=lambda M, j, t: M.a[j, t] >= -largest * M.s[j, t])
    M.read_if_split = pyo.Constraint(J, T_B, rule=lambda M, j, t: M.s[j, t] <= M.d[t])
    M.split_reads = pyo.Constraint(T_B, rule=lambda M, t: sum(M.s[j, t] for j in J) >= M.d[t])
    M.offset_above = pyo.Constraint(T_B, rule=lambda M, t: M.b[t] <= reach * M.d[t])
    M.offset_below = pyo.Constraint(T_B, rule=lambda M, t: M.b[t] >= -reach * M.d[t])
    M.parent_splits = pyo.Constraint(T_B[1:], rule=lambda M, t: M.d[t] <= M.d[t // 2])
    left = [(i, m, t) for t in T_L for m in heap.left_ancestors(t) for i in samples]
    right = [(i, m, t) for t in T_L for m in heap.right_ancestors(t) for i in samples]
    M.left = pyo.Constraint(
        left,
        rule=lambda M, i, m, t: sum(M.a[j, m] * x[i, j] for j in J) + mu <= M.b[m] + (2 * reach + mu) * (1 - M.z[i, t]),
    )
    M.right = pyo.Constraint(
        right,
        rule=lambda M, i, m, t: sum(M.a[j, m] * x[i, j] for j in J) >= M.b[m] - 2 * reach * (1 - M.z[i, t]),
    )
    _add_further_limits(M, problem, max_splits)
    return M


def _add_further_limits(M: Any, problem: Problem, max_splits: int | None) -> None:
    """Add what the paper lacks: split_size, allowed_splits, sensor budget, number of splits."""
    J, T_B = range(problem.n_features), list(M.d.keys())
    if problem.max_split_size < problem.n_features:
        size = problem.max_split_size
        M.split_size = pyo.Constraint(T_B, rule=lambda M, t: sum(M.s[j, t] for j in J) <= size * M.d[t])
    if problem.allowed_splits is not None:
        groups = problem.allowed_splits
        Q = range(len(groups))
        M.group = pyo.Var(Q, T_B, domain=pyo.Binary)
        M.one_group = pyo.Constraint(T_B, rule=lambda M, t: sum(M.group[q, t] for q in Q) == M.d[t])
        M.read_in_group = pyo.Constraint(
            J, T_B, rule=lambda M, j, t: M.s[j, t] <= sum(M.group[q, t] for q in Q if j in groups[q])
        )
    add_limits(M, problem, M.s, None if max_splits is None else (sum(M.s.values()), max_splits))
