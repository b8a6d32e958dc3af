"""Thresholds: axis-aligned splits without epsilon and without big M.

    S_mjr   1 if node m splits on feature j at a cut of r or more;   S_mj0 >= S_mj1 >= ...
    sample i goes left at m   <=>   sum_j S_m,j,rank(i, j) = 1        (linear, exact: no threshold is a number here)
    node m splits             <=>   d_m = sum_j S_mj0 = 1

Branching on S_mjr halves an interval of thresholds, where branching on the paper's b_t moves nothing.

Cuts that no better tree needs are left out of the model (`octmip.trees.mip.blocks.fixing`); those that remain are
numbered again.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from octmip.trees.encoding import Ranks
from octmip.trees.mip.blocks import axis
from octmip.trees.mip.blocks.heap import Heap, Placed
from octmip.trees.mip.blocks.hyperplanes import Band
from octmip.trees.mip.blocks.scope import Scope
from octmip.trees.mip.rows import Columns, Rows, Term
from octmip.trees.nodes.tree import Leaf, Split

Cuts = dict[int, NDArray[np.int64]]  # by feature: the admissible cuts, ascending


@dataclass(frozen=True, slots=True, eq=False)
class Thresholds:
    """The splits of a formulation as columns S: for each branch node and feature one column for each admissible cut."""

    ranks: Ranks
    cuts: Mapping[int, Cuts]
    S: Mapping[int, Mapping[int, Columns]]

    @property
    def scope(self) -> Scope:
        """The trees that a bound speaks about; the notes count the cuts that each branch node may make."""
        return Scope(notes={"cuts": {str(m): sum(map(len, of_node.values())) for m, of_node in self.cuts.items()}})

    def first(self, m: int) -> Columns:
        """Return the columns S_mj0, one for each feature that node m may split on: their sum is d_m."""
        return np.array([S[0] for S in self.S[m].values()], dtype=np.int64)

    def feature_columns(self, m: int) -> dict[int, int]:
        """Return, by feature, the column that is 1 when node m splits on it."""
        return {j: int(S[0]) for j, S in self.S[m].items()}

    def left_terms(self, m: int, samples: NDArray[np.int64]) -> Term:
        """Return the terms (n_samples, n_features) whose sum is 1 where a sample goes left at node m, 0 elsewhere."""
        shape = (len(samples), max(len(self.S[m]), 1))
        columns, ones = np.zeros(shape, dtype=np.int64), np.zeros(shape)
        for place, (j, S) in enumerate(self.S[m].items()):
            at = np.searchsorted(self.cuts[m][j], self.ranks.column(j)[samples])
            inside = at < len(S)
            columns[inside, place], ones[inside, place] = S[at[inside]], 1.0
        return columns, ones

    def add_routing(self, rows: Rows, m: int, samples: NDArray[np.int64], left: Term, right: Term) -> None:
        """Add that what flows below the left (right) side of node m has gone left (right) there."""
        columns, ones = self.left_terms(m, samples)
        rows.add("left", -np.inf, 0, left, (columns, -ones))
        rows.add("right", -np.inf, 1, right, (columns, ones))

    def by_cut(self, m: int, value: Mapping[int, NDArray[np.float64]]) -> tuple[Columns, NDArray[np.float64]]:
        """Return the terms whose sum is ``value[j][cut]`` of the cut that node m makes, 0 when it makes none."""
        columns, numbers = [np.zeros(0, dtype=np.int64)], [np.zeros(0)]
        for j, S in self.S[m].items():
            columns.append(S)
            numbers.append(np.diff(value[j][self.cuts[m][j]], prepend=0.0))
        return np.concatenate(columns), np.concatenate(numbers)

    def set(self, values: NDArray[np.float64], placed: Placed, bands: Mapping[int, Band]) -> bool:
        """Write the splits of a tree into `values`; False when a cut of it is not admissible. `bands` is not needed."""
        for m, split in placed.splits.items():
            if not isinstance(split, Split):
                return False
            (feature,) = split.features
            cuts = self.cuts[m].get(feature, np.zeros(0, dtype=np.int64))
            at = int(np.searchsorted(cuts, axis.cut_of(split, self.ranks)))
            if at == len(cuts) or cuts[at] != axis.cut_of(split, self.ranks):
                return False
            values[self.S[m][feature][: at + 1]] = 1
        return True

    def splits(self, values: NDArray[np.float64]) -> dict[int, Split]:
        """Return the split of each branch node that has one."""
        found = {}
        for m, S in self.S.items():
            chosen = [j for j in S if values[S[j][0]] > 0.5]
            if chosen:
                j = chosen[0]
                cut = int(self.cuts[m][j][int((values[S[j]] > 0.5).sum()) - 1])
                found[m] = Split(j, axis.threshold_at(j, cut, self.ranks), Leaf(0), Leaf(0))
        return found


def add_thresholds(
    rows: Rows,
    ranks: Ranks,
    heap: Heap,
    cuts: Mapping[int, Cuts],
    max_splits: int | None,
    *,
    penalty: float,
) -> Thresholds:
    """Add S, its monotony, at most one feature per node, no split below an unsplit node, at most `max_splits`."""
    lengths = [len(of_feature) for at_node in cuts.values() for of_feature in at_node.values()]
    count = sum(lengths)
    price = np.zeros(count)  # the penalty is paid by S_mj0, the first column of each feature
    price[np.cumsum([0, *lengths[:-1]])[: len(lengths)]] = penalty
    flat = rows.columns("S", (range(count),), cost=price, integer=True)
    S: dict[int, dict[int, Columns]] = {}
    taken = 0
    for m, at_node in cuts.items():
        S[m] = {}
        for j, of_feature in at_node.items():
            S[m][j] = flat[taken : taken + len(of_feature)]
            taken += len(of_feature)
    thresholds = Thresholds(ranks, cuts, S)
    for at_node in S.values():
        for columns in at_node.values():
            if len(columns) > 1:
                rows.add("monotone", -np.inf, 0, (columns[1:, None], 1.0), (columns[:-1, None], -1.0))
    for m in heap.branches:
        if len(thresholds.first(m)):
            rows.add("one_feature", -np.inf, 1, (thresholds.first(m), 1.0))
            if m > 1:
                rows.add("parent_splits", -np.inf, 0, (thresholds.first(m), 1.0), (thresholds.first(m // 2), -1.0))
    if max_splits is not None:
        rows.add("max_splits", -np.inf, max_splits, (np.concatenate([thresholds.first(m) for m in heap.branches]), 1.0))
    return thresholds
