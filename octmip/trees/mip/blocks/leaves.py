"""Leaves: the columns and rows of Bertsimas & Dunn that OCT and OCT-H share, lettered as in `octmip.trees.mip.oct`."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from octmip.trees.mip.blocks.heap import Heap, Placed
from octmip.trees.mip.prices import Prices
from octmip.trees.mip.rows import Columns, Rows, Term
from octmip.trees.question.problem import Problem


@dataclass(frozen=True, slots=True, eq=False)
class Leaves:
    """The columns of the leaves, by letter."""

    z: Columns  # (n_samples, n_leaves)
    l: Columns  # noqa: E741  (n_leaves,) the paper's letter
    c: Columns  # (n_classes, n_leaves)
    N_kt: Columns  # (n_profiles, n_leaves); a profile is a class, unless `Prices` parts its samples
    N_t: Columns  # (n_leaves,)
    L: Columns  # (n_leaves,)

    def set(self, values: NDArray[np.float64], prices: Prices, heap: Heap, placed: Placed) -> None:
        """Write a tree laid into the heap into `values` (n_columns,)."""
        values[self.z[np.arange(len(self.z)), placed.position]] = 1
        for t, leaf in enumerate(heap.leaves):
            rows = np.flatnonzero(placed.position == t)
            if len(rows):
                label = placed.labels[leaf]
                values[self.l[t]] = values[self.c[label, t]] = 1
                values[self.N_kt[:, t]] = np.bincount(prices.profile[rows], prices.weights[rows], prices.n_profiles)
                values[self.N_t[t]] = prices.weights[rows].sum()
                values[self.L[t]] = prices.of_labels(rows)[label]

    def labels(self, values: NDArray[np.float64], heap: Heap) -> dict[int, int]:
        """Return the label of every leaf that has one."""
        chosen = values[self.c].argmax(axis=0)
        return {leaf: int(chosen[t]) for t, leaf in enumerate(heap.leaves) if values[self.l[t]] > 0.5}


def add_leaves(rows: Rows, problem: Problem, heap: Heap, prices: Prices) -> Leaves:
    """Add the leaves' columns and rows, eq. 6-8, 15-16, 18, 20-22, and return the columns."""
    samples, leaves, classes = range(problem.samples.n_samples), heap.leaves, range(problem.samples.n_classes)
    z = rows.columns("z", (samples, leaves), integer=True)
    l = rows.columns("l", (leaves,), integer=True)  # noqa: E741
    c = rows.columns("c", (classes, leaves), integer=True)
    profiles = range(prices.n_profiles)
    N_kt = rows.columns("N_kt", (profiles, leaves), upper=np.inf)
    N_t = rows.columns("N_t", (leaves,), upper=np.inf)
    L = rows.columns("L", (leaves,), upper=np.inf, cost=1.0)
    rows.add("one_leaf", 1, 1, (z, 1.0))
    rows.add("leaf_used", -np.inf, 0, (z.reshape(-1, 1), 1.0), (np.tile(l, len(z))[:, None], -1.0))
    rows.add("leaf_size", 0, np.inf, (z.T, 1.0), (l[:, None], -float(problem.shape.leaf_size)))
    rows.add("one_class", 0, 0, (c.T, 1.0), (l[:, None], -1.0))
    rows.add("leaf_weight", 0, 0, (N_t[:, None], 1.0), (z.T, -prices.weights))
    for r in profiles:
        own = np.flatnonzero(prices.profile == r)
        rows.add("class_weight", 0, 0, (N_kt[r][:, None], 1.0), (z[own].T, -prices.weights[own]))
    for k in classes:
        _add_cost_rows(rows, prices, k, Leaves(z, l, c, N_kt, N_t, L))
    return Leaves(z, l, c, N_kt, N_t, L)


def _add_cost_rows(rows: Rows, prices: Prices, k: int, leaves: Leaves) -> None:
    """Add eq. 20 and 21 for class k: L_t - (cost of predicting k in t) - W c_kt >= -W, and L_t - cost - W c_kt <= 0."""
    W = prices.worst
    cost: list[Term]
    if prices.is_zero_one:
        cost = [(leaves.N_t[:, None], -1.0), (leaves.N_kt[k][:, None], 1.0)]
    else:
        cost = [(leaves.N_kt.T, -prices.costs[:, k])]
    L, c = leaves.L[:, None], leaves.c[k][:, None]
    rows.add("cost_if_chosen", -W, np.inf, (L, 1.0), *cost, (c, -W))
    rows.add("cost_at_most", -np.inf, 0, (L, 1.0), *cost, (c, -W))
