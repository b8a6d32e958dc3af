"""What stumps cost on a part of the samples: prices of the samples left and right of each cut, by class.

On the left of cut a (ranks up to a) a leaf costs all prices there less those of the class with most; so on the right.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from octmip.pseudo_boolean.question import Question


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
    least
        what a stump costs at least, the penalty included, or a leaf.
    """

    total: NDArray[np.int64]
    left: tuple[NDArray[np.int64], ...]
    cost_left: tuple[NDArray[np.int64], ...]
    cost_right: tuple[NDArray[np.int64], ...]
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

    def stumps(self, part: NDArray[np.bool_]) -> StumpCosts:
        """Return the costs of stumps on a part of the samples, (n_samples,) bool."""
        counted = self._by_class * part[:, None]
        total = counted.sum(axis=0)
        least = int(total.sum() - total.max())
        left, lefts, rights = [], [], []
        for order, ends in zip(self._order, self._ends, strict=True):
            below = np.cumsum(counted[order], axis=0)[np.maximum(ends, 0)]
            below[ends < 0] = 0
            beyond = total - below
            cost_left = below.sum(axis=1) - below.max(axis=1)
            cost_after = beyond.sum(axis=1) - beyond.max(axis=1)
            cost_right = np.concatenate([[total.sum() - total.max()], cost_after[:-1]])
            least = min(least, int((cost_left + cost_after)[:-1].min()) + self.question.penalty)
            left.append(below)
            lefts.append(cost_left)
            rights.append(cost_right)
        return StumpCosts(total, tuple(left), tuple(lefts), tuple(rights), least)
