"""Stuck gauges: readings have noise, so a gauge that varied and then shows one value again and again has failed.

Let p be the share of readings that repeat the one before: of this gauge before its last run, or of all others if that
is more, as coarse digits make it. Independent readings have the value v with probability P(v), and p = sum_v P(v)^2, so
that P(v) <= sqrt(p) and a run of k repeats has at most p^(k/2). A gauge is stuck where that is below rate / (n_gauges
horizon), so that a horizon names a sound one with at most about `rate`.
"""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


@dataclass(slots=True, eq=False)
class Repeats:
    """Counts of repeated readings of one asset.

    Attributes
    ----------
    last
        (n_gauges,) the last reading of each gauge; NaN before its first.

    Examples
    --------
    >>> repeats = Repeats(np.full(3, np.nan))
    >>> for k in range(30):
    ...     repeats.count(np.array([k % 7, min(k, 12), k % 5], dtype=float))
    >>> repeats.is_stuck(1e-4).tolist()
    [False, True, False]
    """

    last: Floats
    _run: Floats = field(init=False, repr=False)
    _repeats: Floats = field(init=False, repr=False)
    _pairs: Floats = field(init=False, repr=False)

    def __post_init__(self) -> None:
        self._run, self._repeats, self._pairs = np.zeros((3, len(self.last)))

    def count(self, row: Floats) -> None:
        """Take a reading (n_gauges,), NaN where missing."""
        has_changed = (row != self.last) & ~np.isnan(row - self.last)
        ended = np.where(has_changed, self._run, 0.0)
        self._repeats, self._pairs = self._repeats + ended, self._pairs + ended + has_changed
        self._run = np.where(has_changed, 0.0, self._run + (row == self.last))
        self.last = np.where(np.isnan(row), self.last, row)

    def is_stuck(self, rate: float) -> NDArray[np.bool_]:
        """Return which gauges (n_gauges,) repeat themselves as a sound one does with less than the probability."""
        own = (self._repeats + 1.0) / (self._pairs + 1.0)
        repeats, pairs = self._repeats + self._run, self._pairs + self._run
        others = (repeats.sum() - repeats + 1.0) / (pairs.sum() - pairs + 1.0)
        return np.asarray(np.maximum(own, others) ** (0.5 * self._run) < rate)
