"""What stumps cost on a part of the samples: prices of the samples left and right of each cut, by class.

On the left of cut a (ranks up to a) a leaf costs all prices there less those of the class with most; so on the right.
"""

from collections.abc import Collection
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from octmip.pseudo_boolean.question import Question

TOO_FEW = 2**62
"""Cost of a side that cannot have as many samples as a leaf needs."""


@dataclass(frozen=True, slots=True, eq=False)
class StumpCosts:
    """Least costs on a part of the samples.

    Attributes
    ----------
    total
        (n_classes,) prices of the part.
    left
        for each column (n_ranks, n_classes): prices of the samples of ranks up to r.
    cost_left, cost_right
        for each column (n_ranks,): what a leaf of the samples of ranks up to r, from r on, costs at least.
    first, last
        for each column: cuts before the first and after the last leave a leaf with too few samples.
    least
        what a stump costs at least, the penalty included, or a leaf; `TOO_FEW` where there is none.
    """

    total: NDArray[np.int64]
    left: tuple[NDArray[np.int64], ...]
    cost_left: tuple[NDArray[np.int64], ...]
    cost_right: tuple[NDArray[np.int64], ...]
    first: tuple[int, ...]
    last: tuple[int, ...]
    least: int


class Counts:
    """Counts of a question's samples in the order of each column."""

    def __init__(self, question: Question) -> None:
        self.question = question
        by_class = np.zeros((question.n_samples, question.n_classes), dtype=np.int64)
        by_class[np.arange(question.n_samples), question.labels] = question.prices
        self._by_class = by_class
        self._order = [np.argsort(ranks, kind="stable") for ranks in question.ranks]
        self._ends = [
            np.searchsorted(ranks[order], np.arange(n), side="right") - 1
            for ranks, order, n in zip(question.ranks, self._order, question.n_ranks.tolist(), strict=True)
        ]

    def _feasible(self, j: int, candidates: NDArray[np.bool_]) -> tuple[int, int]:
        """Return the first and the last cut of a column that leave both leaves enough candidates."""
        n_cuts, size = int(self.question.n_ranks[j]) - 1, self.question.leaf_size
        if size == 1:  # a leaf without samples is no tree, but costs no less than one
            return 0, n_cuts - 1
        below = np.cumsum(np.bincount(self.question.all_ranks[j][candidates], minlength=n_cuts + 1))
        first = int(np.searchsorted(below, size))
        return min(first, n_cuts), int(np.searchsorted(below, below[-1] - size, side="right")) - 1

    def stumps(
        self, part: NDArray[np.bool_], candidates: NDArray[np.bool_], columns: Collection[int] | None = None
    ) -> StumpCosts:
        """Return the costs of stumps where a part of the samples, (n_samples,), surely is.

        `candidates`, (n_all_samples,), may be there; `columns` are those that a stump may read (None: all).
        """
        counted = self._by_class * part[:, None]
        total = counted.sum(axis=0)
        least = int(total.sum() - total.max())
        if candidates.sum() < self.question.leaf_size:
            least = TOO_FEW
        left, lefts, rights, cuts = [], [], [], []
        for j, (order, ends) in enumerate(zip(self._order, self._ends, strict=True)):
            below = np.cumsum(counted[order], axis=0)[np.maximum(ends, 0)]
            below[ends < 0] = 0
            beyond = total - below
            cost_left = below.sum(axis=1) - below.max(axis=1)
            cost_after = beyond.sum(axis=1) - beyond.max(axis=1)
            cost_right = np.concatenate([[total.sum() - total.max()], cost_after[:-1]])
            first, last = self._feasible(j, candidates)
            if first <= last and (columns is None or j in columns):
                least = min(least, int((cost_left + cost_after)[first : last + 1].min()) + self.question.penalty)
            cuts.append((first, last))
            left.append(below)
            lefts.append(cost_left)
            rights.append(cost_right)
        firsts, lasts = zip(*cuts, strict=True) if cuts else ((), ())
        return StumpCosts(total, tuple(left), tuple(lefts), tuple(rights), firsts, lasts, least)
