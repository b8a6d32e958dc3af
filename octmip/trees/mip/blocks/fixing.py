"""Fixing of cuts: those that no tree better than the known one needs are left out of the model.

Three reasons to leave a cut out, each with its proof; a cut that the known tree makes always stays: it is the start.

* Boundary (last level, leaf_size 1): a cut between two values whose samples are all of one class is not needed. The
  cost of a stump is linear while such a class moves across, so one of the two neighbouring cuts costs no more; repeat
  until a value of another class is met, or one side is empty and the split is not needed at all.
* Class counts at the root (level 1): a root cut whose class-count bound reaches the known objective leads to no better
  tree (`octmip.trees.mip.blocks.classcount`).
* Class counts in pairs (level 2): given a root cut, the class weights on both its sides are known, and so is what every
  cut of a child can earn there at most. A root cut stays only if the best cuts of its two children together may beat
  the known objective; a child's cut stays only if it may, together with some root cut that stays and the best of the
  other child. At depth 2 each child's leaves are single, the counts are exact, and this alone tries every tree: what
  HiGHS then proves, it proves about few cuts. It is skipped where it takes more than `MOST_WORK` steps.

A child's cut must also be payable beside the root's sensor. Leaf sizes and numbers of splits are not looked at: these
only take trees away, so every bound stays one.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from octmip.trees.encoding import Ranks
from octmip.trees.mip.blocks import axis
from octmip.trees.mip.blocks.classcount import ClassCount
from octmip.trees.mip.blocks.heap import Heap, Placed
from octmip.trees.mip.blocks.thresholds import Cuts
from octmip.trees.mip.rows import LimitCheck
from octmip.trees.nodes.tree import Split
from octmip.trees.question.problem import Problem

MOST_WORK = 3e8  # root cuts x cuts x classes: some seconds


def admissible_cuts(
    problem: Problem,
    counts: ClassCount,
    heap: Heap,
    best: Placed,
    price: float,
    *,
    level: int,
    check: LimitCheck,
    root: Cuts | None,
) -> dict[int, Cuts]:
    """Return the cuts of each branch node that a better tree than `best` may need, and those of `best` itself.

    Parameters
    ----------
    price
        that of `best`.
    level
        0 leaves every cut in; 1 boundary and class counts at the root; 2 class counts in pairs too.
    check
        called now and then; may raise when a limit is reached.
    root
        the only cuts of the root beside that of `best`; None: any.
    """
    ranks = counts.ranks
    usable = axis.usable_features(problem, ranks)
    everything = {j: np.arange(axis.n_cuts(ranks)[j]) for j in usable}
    admissible: dict[int, Cuts] = {}
    for m in heap.branches:
        check()
        admissible[m] = dict(everything)
    at_root = everything if root is None else {j: np.asarray(cuts) for j, cuts in root.items()}
    admissible[1] = dict(at_root)
    if level >= 1:
        better = price - 1e-9 * max(1.0, price)
        admissible[1] = {j: cuts[counts.bound_by_cut(j)[cuts] < better] for j, cuts in at_root.items()}
        if problem.shape.leaf_size == 1:
            boundaries = {j: _boundaries(problem, ranks, j) for j in usable}
            for m in filter(heap.is_last_level, heap.branches):
                admissible[m] = {j: np.intersect1d(admissible[m][j], boundaries[j]) for j in usable}
        if level >= 2 and heap.depth >= 2 and usable:
            _fix_pairs(admissible, _Pairs(problem, ranks, counts, tuple(usable)), better, check)
    for m, split in best.splits.items():
        if isinstance(split, Split):
            own = admissible[m].get(split.feature, np.zeros(0, dtype=np.int64))
            admissible[m][split.feature] = np.union1d(own, axis.cut_of(split, ranks))
    return {m: {j: cuts.astype(np.int64) for j, cuts in of.items() if len(cuts)} for m, of in admissible.items()}


def _boundaries(problem: Problem, ranks: Ranks, j: int) -> NDArray[np.int64]:
    """Return the cuts of feature j whose two neighbouring values are not all of one same class."""
    present = np.zeros((ranks.n_values[j], problem.samples.n_classes), dtype=bool)
    present[ranks.column(j), problem.samples.codes] = True
    only = np.where(present.sum(axis=1) == 1, present.argmax(axis=1), -1)
    return np.flatnonzero((only[:-1] != only[1:]) | (only[:-1] < 0))


def _fix_pairs(admissible: dict[int, Cuts], pairs: "_Pairs", better: float, check: LimitCheck) -> None:
    """Fix the cuts of the root and of its children, in place."""
    roots = admissible[1]
    if sum(map(len, roots.values())) * pairs.n_values * pairs.counts.prices.n_profiles > MOST_WORK:
        return
    stays = {2: np.zeros(pairs.n_values, dtype=bool), 3: np.zeros(pairs.n_values, dtype=bool)}
    for j, cuts in roots.items():
        kept = []
        payable = pairs.payable_with(j)
        for cut in cuts:
            check()
            is_left = pairs.ranks.column(j) <= cut
            left, most_left = pairs.earned(is_left, payable)
            right, most_right = pairs.earned(~is_left, payable)
            room = pairs.counts.worst + pairs.counts.prices.penalty - better  # what a better tree must earn more than
            if most_left + most_right > room:
                kept.append(cut)
                stays[2] |= left + most_right > room
                stays[3] |= most_left + right > room
        roots[j] = np.array(kept, dtype=np.int64)
    for m, flat in stays.items():
        admissible[m] = {j: cuts[flat[pairs.first[j] + cuts]] for j, cuts in admissible[m].items()}


@dataclass(frozen=True, slots=True, eq=False)
class _Pairs:
    """Earnings of the cuts of a child on any part of the samples; all values of all features in one flat array."""

    problem: Problem
    ranks: Ranks
    counts: ClassCount
    usable: tuple[int, ...]

    @property
    def sizes(self) -> NDArray[np.int64]:
        """(n_usable,) number of values of each usable feature."""
        return np.array([self.ranks.n_values[j] for j in self.usable])

    @property
    def n_values(self) -> int:
        """Length of the flat array."""
        return int(self.sizes.sum())

    @property
    def first(self) -> dict[int, int]:
        """Position of each usable feature's first value in the flat array."""
        return dict(zip(self.usable, np.cumsum([0, *self.sizes[:-1]]).tolist(), strict=True))

    def payable_with(self, j: int) -> NDArray[np.bool_]:
        """Return the values, shape (n_values,), of the features whose sensor the budget allows beside that of j."""
        problem, sensor = self.problem, self.problem.shape.sensor_index[list(self.usable)]
        both = problem.shape.sensor_costs[sensor] + problem.shape.sensor_costs[problem.shape.sensor_index[j]]
        is_payable = (both <= problem.shape.sensor_limit) | (sensor == problem.shape.sensor_index[j])
        return np.repeat(is_payable, self.sizes)

    def earned(self, rows: NDArray[np.bool_], payable: NDArray[np.bool_]) -> tuple[NDArray[np.float64], float]:
        """Return the earnings (n_values,) of a child with the samples `rows` by each payable cut, and their maximum."""
        prices, n_leaves = self.counts.prices, 2 ** (self.problem.shape.depth - 2)
        n_profiles = prices.n_profiles
        first = np.array(list(self.first.values()))[:, None]
        place = (self.ranks.ranks[list(self.usable)][:, rows].astype(np.int64) + first) * n_profiles + prices.profile[
            rows
        ]
        weights = np.tile(prices.weights[rows], len(self.usable))
        flat = np.bincount(place.ravel(), weights, self.n_values * n_profiles).reshape(-1, n_profiles)
        total = np.bincount(prices.profile[rows], prices.weights[rows], n_profiles)
        feature = np.repeat(np.arange(len(self.usable)), self.sizes)[:, None]
        left = flat.cumsum(axis=0) - feature * total  # every feature before has added the total once
        counts = self.counts
        by_cut = counts.earned(left, n_leaves) + counts.earned(total - left, n_leaves) - prices.penalty
        by_cut[np.cumsum(self.sizes) - 1] = -np.inf  # the last value of a feature is no cut
        by_cut[~payable] = -np.inf
        unsplit = float(counts.earned(total[None, :].astype(np.float64), 1)[0])
        return by_cut, max(unsplit, float(by_cut.max()))
