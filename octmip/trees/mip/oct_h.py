"""OCT-H: optimal classification trees with hyperplane splits, as Bertsimas & Dunn print them.

    letter    word
    a_jt      coefficient of feature j at node t, in [-1, 1], features scaled to [0, 1]
    ahat_jt   at least |a_jt|; their sum is at most d_t
    s_jt      1 if node t reads feature j
    b_t       offset of node t, in [-d_t, d_t]
    d_t       1 if node t splits
    mu        strictness: how far left of b a sample must lie to be left
    The letters of the leaves (z, l, c, N, L, alpha, Lhat, W) are those of `octmip.trees.mip.oct`.

    minimise    (1 / Lhat) sum_t L_t + alpha sum_jt s_jt
    subject to  sum_j ahat_jt <= d_t,   ahat_jt >= a_jt,   ahat_jt >= -a_jt,   -s_jt <= a_jt <= s_jt
                s_jt <= d_t,   sum_j s_jt >= d_t,   -d_t <= b_t <= d_t,   d_t <= d_p(t)
                a_m'x_i + mu <= b_m + (2 + mu)(1 - z_it)                     m in A_L(t)
                a_m'x_i >= b_m - 2 (1 - z_it)                                m in A_R(t)
                and the rows of the leaves as in OCT

An unsplit node does not leak here: d_m = 0 leaves mu <= 0 in the left row, so no sample is left of it.

What the printed form leaves open, and what is done about it
* OCT-H(mu) is no relaxation of OCT: an axis-aligned tree whose neighbouring samples are closer than mu is outside. The
  Solution is the best of both kinds (OCT-H's own tree, and the tree it started from), and `details["scope"]` says over
  which trees the bound is proven. mu is chosen from the data: `octmip.trees.mip.blocks.hyperplanes`.
* split_size, allowed_splits, sensor budget and integer normals are more rows: `octmip.trees.mip.blocks.hyperplanes`.
* For integer normals the features are not scaled to [0, 1], and 2 becomes twice the reach of a'x.

Source: Bertsimas & Dunn (2017), Optimal classification trees, Machine Learning 106, section 3, eq. 36.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from octmip.errors import ProblemError
from octmip.trees.methods.options import MipOptions
from octmip.trees.mip.blocks import sensor_rows
from octmip.trees.mip.blocks.heap import Heap, Placed, place
from octmip.trees.mip.blocks.hyperplanes import (
    Hyperplanes,
    add_hyperplanes,
    all_samples_band,
    choose_mu,
    space_of,
)
from octmip.trees.mip.blocks.leaves import Leaves, add_leaves
from octmip.trees.mip.blocks.scope import Scope
from octmip.trees.mip.engine import solver_of
from octmip.trees.mip.prices import Prices, own_prices
from octmip.trees.mip.result import Known
from octmip.trees.mip.rows import Rows
from octmip.trees.nodes.tree import HyperplaneSplit, Split
from octmip.trees.question.problem import Problem


@dataclass(frozen=True, slots=True, eq=False)
class OctH:
    """The rows of OCT-H, and the ways from a tree to a solution and back."""

    problem: Problem
    heap: Heap
    rows: Rows
    hyperplanes: Hyperplanes
    leaves: Leaves
    prices: Prices
    scope: Scope

    def start(self, placed: Placed) -> NDArray[np.float64] | None:
        """Return the values (n_columns,) of a tree laid into the heap, None when it has no band of mu."""
        values = np.zeros(self.rows.n_columns)
        bands = {m: all_samples_band(placed, self.heap, m) for m in placed.splits}
        if not self.hyperplanes.set(values, placed, bands):
            return None
        self.leaves.set(values, self.prices, self.heap, placed)
        sensor_rows.set_sensors(values, self.rows, self.problem, placed)
        return values

    def splits(self, values: NDArray[np.float64]) -> dict[int, Split | HyperplaneSplit]:
        """Return the split of each branch node, read at mid-band."""
        return self.hyperplanes.splits(values)

    def labels(self, values: NDArray[np.float64]) -> dict[int, int]:
        """Return the label of every leaf that holds samples."""
        return self.leaves.labels(values, self.heap)


def encode(
    problem: Problem,
    mu: float,
    *,
    prices: Prices | None = None,
    rows: Rows | None = None,
) -> OctH:
    """Return OCT-H as rows, built family by family.

    Parameters
    ----------
    mu
        strictness.
    prices
        what is minimised; None: the problem's own weights, costs and penalty, as on paper.
    rows
        an empty model to build in, watched for limits; None: a new one.
    """
    prices, rows = prices or own_prices(problem), rows or Rows()
    heap, space = Heap(problem.shape.depth), space_of(problem, centred=False)
    hyperplanes = add_hyperplanes(rows, problem, heap, space, mu, problem.shape.max_splits, penalty=prices.penalty)
    leaves = add_leaves(rows, problem, heap, prices)
    a, b, wide = hyperplanes.a, hyperplanes.b, 2 * space.reach
    for t, leaf in enumerate(heap.leaves):
        z = leaves.z[:, [t]]
        for m in heap.left_ancestors(leaf):
            normal = (a[:, m - 1][None, :], space.x)
            rows.add("left", -np.inf, wide, normal, (b[[m - 1]], -1.0), (z, wide + mu))
        for m in heap.right_ancestors(leaf):
            normal = (a[:, m - 1][None, :], space.x)
            rows.add("right", -wide, np.inf, normal, (b[[m - 1]], -1.0), (z, -wide))
    sensor_rows.add_sensor_rows(rows, problem, [hyperplanes.feature_columns(m) for m in heap.branches])
    return OctH(problem, heap, rows, hyperplanes, leaves, prices, hyperplanes.scope)


def formulate(problem: Problem, known: Known, options: MipOptions) -> OctH:
    """Return OCT-H as rows in what is known; without `mu`, with the strictness that the known tree and the data ask.

    Raises
    ------
    ProblemError
        the problem asks for axis-aligned trees.
    """
    if problem.shape.split != "hyperplane":
        raise ProblemError(f"method 'oct_h' finds hyperplane trees but split is {problem.shape.split!r}; choose 'oct'")
    mu = options.mu
    if mu is None:
        heap = Heap(problem.shape.depth)
        mu = choose_mu(space_of(problem, centred=False), place(known.tree, heap, problem.samples.features), heap)
    return encode(problem, mu, prices=known.prices, rows=known.rows)


solve_oct_h = solver_of("oct_h", formulate)
"""Solve OCT-H with HiGHS; return the best tree of both kinds and the bound over the mu-separated ones.

See `octmip.trees.mip.engine.solver_of`.
"""
