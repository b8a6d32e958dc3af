"""OCT: the optimal classification tree of Bertsimas & Dunn, axis-aligned, exactly as printed.

    letter   word                                                                        equation
    a_jt     1 if node t splits on feature j                                              (2), (4)
    b_t      threshold of node t, on features scaled to [0, 1]                            (3)
    d_t      1 if node t splits                                                           (2), (5)
    p(t)     parent of node t                                                             (5)
    z_it     1 if sample i lies in leaf t                                                 (6), (8)
    l_t      1 if leaf t holds samples                                                    (6), (7)
    N_min    fewest samples in a leaf, `Shape.leaf_size`                                (7)
    A_L(t)   ancestors of leaf t on whose left side it lies; A_R(t) on whose right        (12), (13)
    eps_j    smallest positive difference of the values of feature j; eps_max the largest (12)
    N_kt     weight of class k in leaf t; N_t of all classes                              (15), (16)
    c_kt     1 if leaf t predicts class k                                                 (18)
    L_t      cost of leaf t                                                               (20), (21), (22)
    Lhat     cost of the best tree without a split, `Problem.baseline`                    (23)
    alpha    price of a split beside the normalised cost, leaf_penalty / Lhat             (23)

    minimise    (1 / Lhat) sum_t L_t + alpha sum_t d_t
    subject to  sum_j a_jt = d_t,   0 <= b_t <= d_t,   d_t <= d_p(t)
                z_it <= l_t,   sum_i z_it >= N_min l_t,   sum_t z_it = 1,   sum_k c_kt = l_t
                a_m'x_i >= b_m - (1 - z_it)                                  m in A_R(t)
                a_m'(x_i + eps) <= b_m + (1 + eps_max)(1 - z_it)             m in A_L(t)
                L_t >= N_t - N_kt - W (1 - c_kt),   L_t <= N_t - N_kt + W c_kt,   L_t >= 0

The objective here is Lhat times the printed one, which is the objective of every other solver; both are reported.
Weights enter N_kt and N_t, W is their sum (the printed n). With a cost matrix C, N_t - N_kt becomes the cost of
predicting k in leaf t, sum_i w_i C[y_i, k] z_it, which is the same number when C is 0/1; W becomes sum_i w_i max C.

Where this departs from print, and why
* Unsplit nodes leak in the printed form. With d_m = 0 the left row reads 0 <= 0 and the right row 0 >= 0 at z = 1, so
  samples scatter over both sides as it suits the objective: on iris at depth 2 the printed form has an "optimum" of 0
  whose tree makes 100 errors. The left row is therefore
      a_m'(x_i + eps - eps_min) + eps_min <= b_m + (1 + eps_max)(1 - z_it),
  the same row when d_m = 1, and eps_min <= 0, so z_it = 0, when d_m = 0. ``closed=False`` gives the printed row.
* Features enter as dense ranks / (number of values - 1): exact for axis-aligned trees, and eps_j does not underflow.
  A constant feature has no eps; it cannot be split on.

Source: Bertsimas & Dunn (2017), Optimal classification trees, Machine Learning 106, eq. 2-24.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from octmip.trees.encoding import Ranks, rank_features
from octmip.trees.methods.options import MipOptions, OctOptions
from octmip.trees.mip.benders.bounds import Bounds
from octmip.trees.mip.benders.root_rows import RootRows, add_root_rows, root_bounds
from octmip.trees.mip.blocks import axis, sensor_rows
from octmip.trees.mip.blocks.heap import Heap, Placed
from octmip.trees.mip.blocks.leaves import Leaves, add_leaves
from octmip.trees.mip.blocks.scope import Scope
from octmip.trees.mip.engine import solver_of
from octmip.trees.mip.incumbent import canonicalise
from octmip.trees.mip.prices import Prices, own_prices
from octmip.trees.mip.result import Known
from octmip.trees.mip.rows import Columns, Rows
from octmip.trees.nodes.tree import Leaf, Split
from octmip.trees.question.problem import Problem


@dataclass(frozen=True, slots=True, eq=False)
class Oct:
    """The rows of OCT, its columns by letter, and the ways from a tree to a solution and back."""

    problem: Problem
    ranks: Ranks
    heap: Heap
    rows: Rows
    a: Columns  # (n_features, n_branches)
    b: Columns  # (n_branches,)
    d: Columns  # (n_branches,)
    leaves: Leaves
    prices: Prices
    root: RootRows | None
    scope: Scope = Scope()  # noqa: RUF009  (frozen)

    def start(self, placed: Placed) -> NDArray[np.float64]:
        """Return the values (n_columns,) of a tree laid into the heap."""
        values = np.zeros(self.rows.n_columns)
        for m, split in placed.splits.items():
            (feature,) = split.features
            # The smallest value on the right: the midpoint would break the left row, which asks for a whole eps.
            values[self.b[m - 1]] = (axis.cut_of(split, self.ranks) + 1) / axis.n_cuts(self.ranks)[feature]
            values[self.a[feature, m - 1]] = values[self.d[m - 1]] = 1
        if self.root is not None:
            self.root.set(values, placed.splits.get(1), self.ranks)
        self.leaves.set(values, self.prices, self.heap, placed)
        sensor_rows.set_sensors(values, self.rows, self.problem, placed)
        return values

    def splits(self, values: NDArray[np.float64]) -> dict[int, Split]:
        """Return the split of each branch node, read at mid-band: left when ``x < b - eps_j / 2``."""
        found = {}
        for m in self.heap.branches:
            if values[self.d[m - 1]] > 0.5:
                feature = int(values[self.a[:, m - 1]].argmax())
                cut = int(np.ceil(values[self.b[m - 1]] * axis.n_cuts(self.ranks)[feature] - 0.5)) - 1
                if cut < 0:  # everything goes right, as at a node without a split
                    continue
                found[m] = Split(feature, axis.threshold_at(feature, cut, self.ranks), Leaf(0), Leaf(0))
        return found

    def labels(self, values: NDArray[np.float64]) -> dict[int, int]:
        """Return the label of every leaf that holds samples."""
        return self.leaves.labels(values, self.heap)


def encode(
    problem: Problem,
    *,
    closed: bool = True,
    prices: Prices | None = None,
    rows: Rows | None = None,
    root: Bounds | None = None,
) -> Oct:
    """Return OCT as rows, built family by family.

    Parameters
    ----------
    closed
        whether unsplit nodes are kept from leaking (see the module).
    prices
        what is minimised; None: the problem's own weights, costs and penalty, as on paper.
    rows
        an empty model to build in, watched for limits; None: a new one.
    root
        what the trees below each cut of the root cost at least, for the rows of Benders; None: the rows as printed.
    """
    prices, rows = prices or own_prices(problem), rows or Rows()
    ranks, heap = rank_features(problem), Heap(problem.shape.depth)
    x, eps = scaled_features(ranks)
    usable = np.isin(np.arange(problem.samples.n_features), axis.usable_features(problem, ranks))
    features, branches = range(problem.samples.n_features), heap.branches
    a = rows.columns("a", (features, branches), upper=np.repeat(usable[:, None], len(branches), 1), integer=True)
    b = rows.columns("b", (branches,))
    d = rows.columns("d", (branches,), cost=prices.penalty, integer=True)
    rows.add("one_feature", 0, 0, (a.T, 1.0), (d[:, None], -1.0))
    rows.add("threshold", -np.inf, 0, (b[:, None], 1.0), (d[:, None], -1.0))
    if len(branches) > 1:
        parent = np.array([m // 2 - 1 for m in branches[1:]])
        rows.add("parent_splits", -np.inf, 0, (d[1:, None], 1.0), (d[parent][:, None], -1.0))
    if problem.shape.max_splits is not None:
        rows.add("max_splits", -np.inf, problem.shape.max_splits, (d, 1.0))
    leaves = add_leaves(rows, problem, heap, prices)
    shift, room = (eps.min(), 1 + eps.max()) if closed else (0.0, 1 + eps.max())
    for t, leaf in enumerate(heap.leaves):
        z = leaves.z[:, [t]]
        for m in heap.right_ancestors(leaf):
            rows.add("right", -1, np.inf, (a[:, m - 1][None, :], x), (b[[m - 1]], -1.0), (z, -1.0))
        for m in heap.left_ancestors(leaf):
            rows.add(
                "left", -np.inf, room - shift, (a[:, m - 1][None, :], x + eps - shift), (b[[m - 1]], -1.0), (z, room)
            )
    sensor_rows.add_sensor_rows(rows, problem, [dict(enumerate(a[:, m - 1])) for m in branches])
    rows_of_root = None if root is None else add_root_rows(rows, root, a, b, d, leaves, prices.penalty)
    return Oct(problem, ranks, heap, rows, a, b, d, leaves, prices, rows_of_root)


def scaled_features(ranks: Ranks) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return x (n_samples, n_features), dense ranks scaled to [0, 1], and eps (n_features,), 1 if constant."""
    steps = np.maximum(np.array(axis.n_cuts(ranks)), 1)
    return ranks.ranks.T / steps, 1 / steps


def formulate(problem: Problem, known: Known, options: MipOptions) -> Oct:
    """Return OCT as rows in what is known, with the rows of Benders at the root where the options ask for them.

    Raises
    ------
    ProblemError
        the problem asks for hyperplanes.
    """
    axis.require_axis(problem, "oct")
    root = None
    if isinstance(options, OctOptions) and options.root_rows is not None:
        found = root_bounds(problem, known.prices, known.tree, options.root_rows, known.rows.check_limits)
        known.better(problem, canonicalise(problem, found.tree))
        root = found.bounds
    return encode(problem, prices=known.prices, rows=known.rows, root=root)


solve_oct = solver_of("oct", formulate)
"""Solve OCT with HiGHS and return the tree and the bound: `octmip.trees.mip.engine.solver_of`."""
