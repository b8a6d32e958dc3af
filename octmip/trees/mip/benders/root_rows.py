"""Benders' rows of the root as rows of OCT: what the trees below a cut cost at least, for anyone to read.

    letter   word
    c        a cut: a feature j_c and the smallest value on its right, beta_c, as OCT scales it
    x_c      1 if the root makes cut c
    theta    (left, right) least price of a tree for the samples on one side of c (`octmip.trees.mip.benders.bounds`)
    leaf     least price of a single leaf

    sum_c x_c = d_1,   sum_{c of j} x_c = a_j1,   sum_c beta_c x_c = b_1
    sum_{t left of the root}  L_t + penalty sum_{m left}  d_m >= sum_c theta_left,c  x_c
    sum_{t right of the root} L_t + penalty sum_{m right} d_m >= sum_c theta_right,c x_c
    sum_t L_t + penalty sum_{m > 1} d_m >= sum_c (theta_left,c + theta_right,c) x_c + leaf (1 - d_1)

The last row is that of both sides and of a root without a split: without it half a split would pay neither.

No best tree is lost: a root that sends all samples to one side is no better than the split below it at its place. The
coefficients come from class counts, and rise with every subproblem that is solved before. Once no cut is left that may
be cheaper than the best tree, the linear relaxation has the value of that tree.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from octmip.trees.answer.solution import Limits
from octmip.trees.encoding import Ranks
from octmip.trees.mip.benders.bounds import NEVER, Bounds
from octmip.trees.mip.benders.memory import Memory
from octmip.trees.mip.benders.node import NodeSearch
from octmip.trees.mip.benders.run import Runner
from octmip.trees.mip.benders.subproblem import Subproblem
from octmip.trees.mip.blocks import axis
from octmip.trees.mip.blocks.leaves import Leaves
from octmip.trees.mip.engine import Clock
from octmip.trees.mip.prices import Prices
from octmip.trees.mip.rows import Columns, Rows
from octmip.trees.nodes.tree import HyperplaneSplit, Node, Split
from octmip.trees.question.problem import Problem


@dataclass(frozen=True, slots=True, eq=False)
class RootRows:
    """The columns x, and the cuts that they stand for."""

    x: Columns  # (n_cuts,)
    bounds: Bounds

    def set(self, values: NDArray[np.float64], root: Split | HyperplaneSplit | None, ranks: Ranks) -> None:
        """Write the root's split into `values` (n_columns,)."""
        if root is not None:
            cuts, (feature,) = self.bounds.cuts, root.features
            values[self.x[(cuts.feature == feature) & (cuts.rank == axis.cut_of(root, ranks))]] = 1


@dataclass(frozen=True, slots=True, eq=False)
class Root:
    """What is known of the root: bounds of its cuts, the best tree, and the number of subproblems solved for both."""

    bounds: Bounds
    tree: Node
    n_subproblems: int


def root_bounds(
    problem: Problem, prices: Prices, tree: Node, n_subproblems: int, report: Callable[[], None] = lambda: None
) -> Root:
    """Return what so many subproblems teach of the root, fewer where these prove the best tree.

    Parameters
    ----------
    tree
        the best one known.
    report
        called while subproblems run; may raise.
    """
    whole = Subproblem(problem.replace(max_splits=None), prices, np.arange(problem.samples.n_samples))
    runner = Runner(Clock(Limits(), 0.0), 0, report)
    memory = Memory(prices.weights * prices.costs[prices.profile].max(axis=1))
    search = NodeSearch.of(whole, tree, runner.answer, runner.together, memory)
    if n_subproblems > 0 and problem.shape.depth > 1:
        search.run(runner.in_turn, lambda: runner.n_subproblems >= n_subproblems)
    return Root(search.bounds, search.best, runner.n_subproblems)


def add_root_rows(
    rows: Rows, bounds: Bounds, a: Columns, b: Columns, d: Columns, leaves: Leaves, penalty: float
) -> RootRows:
    """Add x and the rows of the module to a model of OCT; `a`, `b`, `d` are its columns of all branch nodes."""
    feature, rank = bounds.cuts.feature, bounds.cuts.rank
    n_cuts = np.array(axis.n_cuts(bounds.ranks))
    is_possible = bounds.price < NEVER
    x = rows.columns("x", (range(len(feature)),), upper=is_possible, integer=True)
    rows.add("root_cut", 0, 0, (x, 1.0), (d[:1], -1.0))
    for j in np.unique(feature):
        rows.add("root_feature", 0, 0, (x[feature == j], 1.0), (a[j, :1], -1.0))
    rows.add("root_threshold", 0, 0, (x, (rank + 1) / n_cuts[feature]), (b[:1], -1.0))
    half, is_left = len(leaves.L) // 2, _is_left(len(d))
    for side, theta, own, inner in (
        ("left", bounds.left, leaves.L[:half], d[1:][is_left]),
        ("right", bounds.right, leaves.L[half:], d[1:][~is_left]),
    ):
        rows.add(f"below_{side}", 0, np.inf, (own, 1.0), (inner, penalty), (x, -np.where(is_possible, theta, 0.0)))
    leaf = float(bounds.prices.of_labels(np.arange(bounds.problem.samples.n_samples)).min())
    both = np.where(is_possible, bounds.price - penalty, 0.0)
    rows.add("below_both", leaf, np.inf, (leaves.L, 1.0), (d[1:], penalty), (d[:1], leaf), (x, -both))
    return RootRows(x, bounds)


def _is_left(n_branches: int) -> NDArray[np.bool_]:
    """Return which branch nodes but the root lie on its left, (n_branches - 1,): nodes 2, 3, ... of a heap."""
    node = np.arange(2, n_branches + 1)
    while (node > 3).any():
        node = np.where(node > 3, node // 2, node)
    return np.asarray(node == 2)
