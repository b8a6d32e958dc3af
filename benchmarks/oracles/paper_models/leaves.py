"""The leaves of OCT and OCT-H as Pyomo constraints: the rows of `octmip.trees.mip.blocks.leaves`, as on paper."""

from typing import Any

import pyomo.environ as pyo

from octmip.trees.mip.blocks.heap import Heap
from octmip.trees.mip.prices import own_prices
from octmip.trees.problem import Problem


def add_leaves(M: Any, problem: Problem, heap: Heap) -> Any:
    """Add the leaves to a Pyomo model and return sum_t L_t."""
    own = own_prices(problem)
    w, y, costs, W, N_min = problem.weights, problem.codes, problem.costs, own.worst, problem.leaf_size
    T_L, samples, K = heap.leaves, range(problem.n_samples), range(problem.n_classes)

    def cost_of(k: int, t: int) -> Any:
        return M.N_t[t] - M.N_kt[k, t] if own.is_zero_one else sum(costs[i, k] * M.N_kt[i, t] for i in K)

    def weight_of(k: int, t: int) -> Any:
        return sum(w[i] * M.z[i, t] for i in samples if y[i] == k)

    M.z = pyo.Var(samples, T_L, domain=pyo.Binary)
    M.l = pyo.Var(T_L, domain=pyo.Binary)
    M.c = pyo.Var(K, T_L, domain=pyo.Binary)
    M.N_kt = pyo.Var(K, T_L, domain=pyo.NonNegativeReals)
    M.N_t = pyo.Var(T_L, domain=pyo.NonNegativeReals)
    M.L = pyo.Var(T_L, domain=pyo.NonNegativeReals)
    M.leaf_used = pyo.Constraint(samples, T_L, rule=lambda M, i, t: M.z[i, t] <= M.l[t])
    M.leaf_size = pyo.Constraint(T_L, rule=lambda M, t: sum(M.z[i, t] for i in samples) >= N_min * M.l[t])
    M.one_leaf = pyo.Constraint(samples, rule=lambda M, i: sum(M.z[i, t] for t in T_L) == 1)
    M.one_class = pyo.Constraint(T_L, rule=lambda M, t: sum(M.c[k, t] for k in K) == M.l[t])
    M.class_weight = pyo.Constraint(K, T_L, rule=lambda M, k, t: M.N_kt[k, t] == weight_of(k, t))
    M.leaf_weight = pyo.Constraint(T_L, rule=lambda M, t: M.N_t[t] == sum(w[i] * M.z[i, t] for i in samples))
    M.cost_if_chosen = pyo.Constraint(K, T_L, rule=lambda M, k, t: M.L[t] >= cost_of(k, t) - W * (1 - M.c[k, t]))
    M.cost_at_most = pyo.Constraint(K, T_L, rule=lambda M, k, t: M.L[t] <= cost_of(k, t) + W * M.c[k, t])
    return sum(M.L[t] for t in T_L)
