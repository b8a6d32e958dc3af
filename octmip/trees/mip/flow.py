"""Flow: the same trees as OCT and OCT-H in rows that bound them far better.

    f_gkt    flow of sample group g that leaf t earns by predicting k          0 <= f_gkt <= c_kt
    c_kt     1 if leaf t predicts class k                                      sum_k c_kt <= 1
    left_gm  1 if group g goes left at branch node m: linear in the columns of the splits

    minimise    sum_g w_g Cmax_g - sum_gkt w_g gain[y_g, k] f_gkt + leaf_penalty * complexity
    subject to  sum_{t below left(m)} sum_k f_gkt <= left_gm,   sum_{t below right(m)} sum_k f_gkt <= 1 - left_gm

where gain[i, k] = Cmax_i - C[i, k] is what predicting k earns over the most expensive label of class i; pairs that earn
nothing have no flow. With 0/1 costs only k = y_g flows, and the objective is the weight that is not earned. Samples of
the same features and class form one group.

Why it is stronger than the printed rows (`octmip.trees.mip.oct`): the big W of L_t >= N_t - N_kt - W (1 - c_kt) is
gone, so the relaxation cannot give every leaf every class; routing is stated once per node for all the leaves below it
instead of once per leaf. Then, each valid because it only removes trees that another tree of at most the same cost
stands for:

* sibling leaves differ: c_k,2t + c_k,2t+1 <= 1 (a split into two leaves of one label is not needed);
* a left leaf names a class only if its parent splits;
* of a hyperplane and its mirror image one is enough: one chosen sample is kept by the rightmost leaf or by none;
* class counts (axis-aligned): the leaves below one side of a cut earn at most G_q of the class weights on that side,
  for every branch node (the samples that reach it are a part of all): see `octmip.trees.mip.blocks.classcount`. At
  depth 1 this closes the root;
* cuts that cannot lead to a better tree than the one known are left out: see `octmip.trees.mip.blocks.fixing`.

Source: the flow of samples through a tree: Aghaei, Gomez & Vayanos (2021), Strong optimal classification trees.
Thresholds as monotone columns, class counts and the fixing of cuts are this project's.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from octmip.trees.encoding import rank_features
from octmip.trees.methods.options import MipOptions
from octmip.trees.mip.blocks import sensor_rows
from octmip.trees.mip.blocks.classcount import ClassCount
from octmip.trees.mip.blocks.fixing import admissible_cuts
from octmip.trees.mip.blocks.groups import Groups, group_samples
from octmip.trees.mip.blocks.heap import Heap, Placed, place
from octmip.trees.mip.blocks.hyperplanes import Hyperplanes, add_hyperplanes, all_samples_band, choose_mu, space_of
from octmip.trees.mip.blocks.scope import Scope
from octmip.trees.mip.blocks.thresholds import Cuts, Thresholds, add_thresholds
from octmip.trees.mip.engine import solver_of
from octmip.trees.mip.prices import Prices, own_prices
from octmip.trees.mip.result import Known
from octmip.trees.mip.rows import Columns, Rows
from octmip.trees.nodes.tree import HyperplaneSplit, Node, Split
from octmip.trees.question.problem import Problem


@dataclass(frozen=True, slots=True, eq=False)
class Flow:
    """The rows of the flow formulation, and the ways from a tree to a solution and back."""

    problem: Problem
    groups: Groups
    heap: Heap
    rows: Rows
    node_splits: Thresholds | Hyperplanes
    c: Columns  # (n_classes, n_leaves)
    f: Columns  # (n_pairs, n_leaves)
    z: Columns | None  # (n_groups, n_leaves), only where leaf sizes are to be counted
    l: Columns | None  # noqa: E741  (n_leaves,)
    prices: Prices
    scope: Scope

    def start(self, placed: Placed) -> NDArray[np.float64] | None:
        """Return the values of a tree laid into the heap, None when the rows leave it out."""
        values = np.zeros(self.rows.n_columns)
        if isinstance(self.node_splits, Hyperplanes):
            placed = placed.turned(self.heap, int(self.groups.sample[self.groups.heaviest]))
        for leaf, label in placed.labels.items():
            values[self.c[label, leaf - self.heap.leaves[0]]] = 1
        position = placed.position[self.groups.sample]
        label_at = np.array([placed.labels.get(leaf, -1) for leaf in self.heap.leaves])
        earns = np.flatnonzero(label_at[position[self.groups.pair_group]] == self.groups.pair_label)
        values[self.f[earns, position[self.groups.pair_group[earns]]]] = 1
        kept = np.zeros(self.problem.samples.n_samples, dtype=bool)
        kept[self.groups.sample if self.z is not None else self.groups.sample[self.groups.pair_group[earns]]] = True
        sides = {m: all_samples_band(placed, self.heap, m) for m in placed.splits}
        if not self.node_splits.set(
            values, placed, {m: (left & kept, right & kept) for m, (left, right) in sides.items()}
        ):
            return None
        if self.z is not None and self.l is not None:
            values[self.z[np.arange(len(position)), position]] = 1
            values[self.l[np.unique(position)]] = 1
        sensor_rows.set_sensors(values, self.rows, self.problem, placed)
        return values

    def splits(self, values: NDArray[np.float64]) -> Mapping[int, Split | HyperplaneSplit]:
        """Return the split of each branch node that has one."""
        return self.node_splits.splits(values)

    def labels(self, values: NDArray[np.float64]) -> dict[int, int]:
        """Return the label of every leaf that has one."""
        chosen = values[self.c]
        return {leaf: int(chosen[:, t].argmax()) for t, leaf in enumerate(self.heap.leaves) if chosen[:, t].max() > 0.5}


def encode(
    problem: Problem,
    best: Node,
    *,
    fix: int = 2,
    class_count: bool = True,
    mu: float | None = None,
    prices: Prices | None = None,
    rows: Rows | None = None,
    root: Cuts | None = None,
) -> Flow:
    """Return the flow formulation of a problem as rows.

    Parameters
    ----------
    best
        the best tree known; cuts that lead to nothing better are left out.
    fix
        0 leaves every cut in, 1 and 2 leave out more and more: the levels of `octmip.trees.mip.blocks.fixing`.
    class_count
        False leaves the class-count rows out.
    mu
        strictness of hyperplanes; None: chosen from the data.
    prices
        what is minimised; None: the problem's own weights, costs and penalty.
    rows
        an empty model to build in, watched for limits; None: a new one.
    root
        the only cuts of the root, axis-aligned, beside that of `best`; None: any.
    """
    shape = problem.shape
    prices, rows = prices or own_prices(problem), rows or Rows()
    ranks, heap = rank_features(problem), Heap(shape.depth)
    counts, groups = ClassCount(problem, ranks, prices), group_samples(problem, ranks, prices)
    laid = place(best, heap, problem.samples.features)
    splits: Thresholds | Hyperplanes
    if shape.max_split_size == 1:
        price = prices.of_tree(problem, best)
        cuts = admissible_cuts(problem, counts, heap, laid, price, level=fix, check=rows.check_limits, root=root)
        splits = add_thresholds(rows, ranks, heap, cuts, shape.max_splits, penalty=prices.penalty)
    else:
        space = space_of(problem)
        strictness = choose_mu(space, laid, heap) if mu is None else mu
        splits = add_hyperplanes(rows, problem, heap, space, strictness, shape.max_splits, penalty=prices.penalty)
    c, f, z, l = _add_leaves(rows, problem, heap, groups, may_turn=isinstance(splits, Hyperplanes))  # noqa: E741
    _add_routing(rows, heap, groups, splits, f if z is None else z, groups.pair_group if z is None else None)
    _add_symmetry(rows, heap, splits, c)
    if class_count and isinstance(splits, Thresholds):
        _add_class_counts(rows, heap, groups, splits, counts, f)
    sensor_rows.add_sensor_rows(rows, problem, [splits.feature_columns(m) for m in heap.branches])
    rows.offset = counts.worst
    return Flow(problem, groups, heap, rows, splits, c, f, z, l, prices, splits.scope)


def _add_leaves(
    rows: Rows, problem: Problem, heap: Heap, groups: Groups, *, may_turn: bool
) -> tuple[Columns, Columns, Columns | None, Columns | None]:
    """Add c, f and, where leaf sizes are to be counted, z and l."""
    leaves, pairs = heap.leaves, range(len(groups.pair_group))
    c = rows.columns("c", (range(problem.samples.n_classes), leaves), integer=True)
    f_most = np.ones((len(groups.pair_group), len(leaves)))
    z_most = np.ones((len(groups.sample), len(leaves)))
    if may_turn:  # of a hyperplane and its mirror image one is enough: one sample lies rightmost wherever it is kept
        f_most[groups.pair_group == groups.heaviest, :-1] = z_most[groups.heaviest, :-1] = 0
    price = -np.repeat(groups.earning[:, None], len(leaves), axis=1)
    # The big M of a hyperplane lets a fraction of a flow through on the wrong side; a threshold's rows do not.
    f = rows.columns("f", (pairs, leaves), upper=f_most, cost=price, integer=may_turn)
    rows.add("one_class", -np.inf, 1, (c.T, 1.0))
    label = c[groups.pair_label]
    rows.add("earned_if_chosen", -np.inf, 0, (f.reshape(-1, 1), 1.0), (label.reshape(-1, 1), -1.0))
    if problem.shape.leaf_size == 1:
        return c, f, None, None
    z = rows.columns("z", (range(len(groups.sample)), leaves), upper=z_most, integer=True)
    l = rows.columns("l", (leaves,), integer=True)  # noqa: E741
    rows.add("one_leaf", 1, 1, (z, 1.0))
    rows.add("leaf_used", -np.inf, 0, (z.reshape(-1, 1), 1.0), (np.tile(l, len(z))[:, None], -1.0))
    rows.add("leaf_size", 0, np.inf, (z.T, groups.size), (l[:, None], -float(problem.shape.leaf_size)))
    rows.add("earned_where_it_lies", -np.inf, 0, (f.reshape(-1, 1), 1.0), (z[groups.pair_group].reshape(-1, 1), -1.0))
    return c, f, z, l


def _add_routing(
    rows: Rows, heap: Heap, groups: Groups, splits: Thresholds | Hyperplanes, flow: Columns, of_pair: Any
) -> None:
    """Add, for every branch node, that what flows below its left (right) side has gone left (right) there."""
    incoming = flow[:, None, :] if of_pair is None else _by_group(flow, of_pair, len(groups.sample))
    if isinstance(splits, Hyperplanes):
        rows.add("one_leaf_earns", -np.inf, 1, _summed(incoming))
    for m in heap.branches:
        left, right = (_summed(incoming[:, :, heap.leaves_under(child)]) for child in (2 * m, 2 * m + 1))
        splits.add_routing(rows, m, groups.sample, left, right)


def _by_group(flow: Columns, of_pair: NDArray[np.int64], n_groups: int) -> Columns:
    """Return the flow columns of each group, shape (n_groups, most pairs, n_leaves), -1 where a group has fewer."""
    count = np.bincount(of_pair, minlength=n_groups)
    place = np.arange(len(of_pair)) - np.concatenate([[0], count.cumsum()[:-1]])[of_pair]
    table = np.full((n_groups, int(count.max(initial=1)), flow.shape[1]), -1, dtype=np.int64)
    table[of_pair, place] = flow
    return table


def _summed(columns: Columns) -> tuple[Columns, NDArray[np.float64]]:
    """Return the term that adds all the columns of each row; -1 stands for none."""
    wide = columns.reshape(len(columns), math.prod(columns.shape[1:]))  # also where there are none
    return np.maximum(wide, 0), (wide >= 0).astype(float)


def _add_symmetry(rows: Rows, heap: Heap, splits: Thresholds | Hyperplanes, c: Columns) -> None:
    """Add that sibling leaves differ and that a left leaf names a class only below a split."""
    left = c[:, 0::2]
    rows.add("siblings_differ", -np.inf, 1, (left.reshape(-1, 1), 1.0), (c[:, 1::2].reshape(-1, 1), 1.0))
    for m in heap.branches:
        if heap.is_last_level(m):
            t = 2 * m - heap.leaves[0]
            rows.add("class_below_split", -np.inf, 0, (c[:, t], 1.0), (splits.first(m), -1.0))


def _add_class_counts(
    rows: Rows, heap: Heap, groups: Groups, splits: Thresholds, counts: ClassCount, f: Columns
) -> None:
    """Add what the leaves below each side of each branch node earn at most, by the cut that the node makes."""
    one_leaf = float(counts.earned(counts.total()[None, :], 1)[0])
    for m in heap.branches:
        n_leaves = len(heap.leaves_under(2 * m))
        sides = {j: counts.earned_by_side(j, n_leaves) for j in splits.cuts[m]}
        for child, side in ((2 * m, 0), (2 * m + 1, 1)):
            leaves = heap.leaves_under(child)
            earned = (f[:, leaves].reshape(1, -1), np.repeat(groups.earning, len(leaves)))
            columns, numbers = splits.by_cut(m, {j: both[side] for j, both in sides.items()})
            # Without a split at m everything lies at its rightmost leaf: one_leaf (1 - d_m).
            unsplit = one_leaf if side else 0.0
            rows.add("class_count", -np.inf, unsplit, earned, (columns, -numbers), (splits.first(m), unsplit))


def formulate(problem: Problem, known: Known, options: MipOptions, fix: int = 2, *, class_count: bool = True) -> Flow:
    """Return the flow formulation as rows in what is known; `fix` and `class_count` as in `encode`."""
    return encode(
        problem,
        known.tree,
        fix=fix,
        class_count=class_count,
        mu=options.mu,
        prices=known.prices,
        rows=known.rows,
    )


solve_flow = solver_of("flow", formulate)
"""Solve the flow formulation with HiGHS and return the tree and the bound: `octmip.trees.mip.engine.solver_of`."""
