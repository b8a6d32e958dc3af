"""Memory: what subproblems of other nodes taught, for the nodes that share their samples.

Two neighbouring cuts at the root leave nearly the same samples on a side, so nearly the same subproblems are asked
there again. By the inequality of `octmip.trees.mip.benders.bounds` each of them bounds those of the neighbour.
"""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from octmip.trees.mip.benders.subproblem import Subproblem

LAST = 2000
"""So many subproblems are looked at, the latest ones."""
RECALLED = 100
"""So many of them are used: those that bound the node's own samples most."""


@dataclass(slots=True, eq=False)
class Memory:
    """Subproblems that were answered: depth, samples of the whole problem (n_samples,), least price.

    Attributes
    ----------
    worst
        (n_samples,) price of each sample's most expensive label.
    """

    worst: NDArray[np.float64]
    entries: list[tuple[int, NDArray[np.bool_], float]] = field(default_factory=list)
    n_old: int = 0

    def branch(self) -> "Memory":
        """Return a memory of the same, which what is added to it does not enter."""
        return Memory(self.worst, self.entries[-LAST:], min(len(self.entries), LAST))

    def merge(self, other: "Memory") -> None:
        """Add what a branch has learnt since it began."""
        self.entries.extend(other.entries[other.n_old :])

    def add(self, depth: int, rows: NDArray[np.int64], price: float) -> None:
        """Add a subproblem by the rows of its samples."""
        samples = np.zeros(len(self.worst), dtype=bool)
        samples[rows] = True
        self.entries.append((depth, samples, price))

    def recall(self, subproblem: Subproblem) -> list[tuple[NDArray[np.bool_], float]]:
        """Return samples of a subproblem, as a mask of its own, and the least cost of a tree one level below there."""
        depth = subproblem.problem.shape.depth - 1
        known = [(samples, price) for level, samples, price in self.entries[-LAST:] if level == depth]
        if not known:
            return []
        masks, prices = np.array([samples for samples, _ in known]), np.array([price for _, price in known])
        outside = self.worst.copy()
        outside[subproblem.rows] = 0.0
        left = prices - masks @ outside
        best = np.argsort(-left, kind="stable")[:RECALLED]
        return [(masks[k][subproblem.rows], float(left[k])) for k in best if left[k] > 0]
