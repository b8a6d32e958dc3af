"""Cuts of a node: all thresholds of all usable features in one order, and what lies left of each.

One running sum over the ranks of all features gives what is left of every cut at once: each feature adds the total of
its samples, which is taken off again. Prices are whole numbers, so nothing is lost by that.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from octmip.trees.encoding import Ranks


class Cut(NamedTuple):
    """A cut by its place among all cuts, with its feature and its rank: ranks up to it go left."""

    place: int
    feature: int
    rank: int


@dataclass(frozen=True, slots=True, eq=False)
class Cuts:
    """All cuts of some features.

    Attributes
    ----------
    feature, rank
        (n_cuts,) of each cut.
    cell
        (n_features, n_samples) the place of each sample's rank among all ranks of all features.
    is_cut
        (n_ranks,) whether a rank is a cut: all but the last of each feature.
    feature_of_rank
        (n_ranks,) place of its feature among those given.
    """

    feature: NDArray[np.int64]
    rank: NDArray[np.int64]
    cell: NDArray[np.int64]
    is_cut: NDArray[np.bool_]
    feature_of_rank: NDArray[np.int64]

    @classmethod
    def of(cls, ranks: Ranks, features: NDArray[np.int64]) -> "Cuts":
        """Return the cuts of some features, in their order."""
        n_values = np.array([ranks.n_values[j] for j in features], dtype=np.int64)
        first = np.cumsum(n_values) - n_values
        place = np.repeat(np.arange(len(features)), n_values)
        rank = np.arange(len(place)) - first[place]
        is_cut = rank < n_values[place] - 1
        cell = ranks.ranks[features].astype(np.int64) + first[:, None]
        return cls(features[place[is_cut]], rank[is_cut], cell, is_cut, place)

    def left_of(
        self, amount: NDArray[np.float64], kind: NDArray[np.int64] | None = None, n_kinds: int = 1
    ) -> NDArray[np.float64]:
        """Return the sum left of each cut of an amount (n_samples,), by kind of sample: (n_cuts, n_kinds)."""
        cell = self.cell if kind is None else self.cell * n_kinds + kind
        amounts = np.broadcast_to(amount, cell.shape).ravel()
        total = np.sum(amount) if kind is None else np.bincount(kind, amount, n_kinds)
        running = np.bincount(cell.ravel(), amounts, len(self.is_cut) * n_kinds).reshape(-1, n_kinds).cumsum(axis=0)
        return np.asarray((running - self.feature_of_rank[:, None] * total)[self.is_cut])
