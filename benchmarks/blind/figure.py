"""Figures with their intervals: shares, means, areas under curves, calibration."""

from dataclasses import dataclass

import numpy as np
from scipy.stats import beta


@dataclass(frozen=True)
class Figure:
    """One row of the table: a share or mean with a 95 % interval.

    Attributes
    ----------
    name
        in words.
    value, low, high
        the figure and its interval; NaN when there is no case.
    n
        cases.
    must
        (least, most) that the figure owes, None for no such.
    """

    name: str
    value: float
    low: float
    high: float
    n: int
    must: tuple[float, float] | None = None

    def owed(self):
        """Return what is owed in words."""
        if self.must is None:
            return ""
        least, most = self.must
        if np.isinf(most):
            return f">= {least:g}"
        return f"<= {most:g}" if np.isinf(least) else f"{least:g}-{most:g}"

    def words(self):
        """Return the row's numbers, and whether they are what is owed."""
        if not self.n:
            return "-"
        text = f"{self.value:.3f} ({self.low:.3f}-{self.high:.3f}), n = {self.n}"
        if self.must is None:
            return text
        least, most = self.must
        if self.value > most and np.isfinite(least):  # a coverage: too wide is not the same as wrong
            return f"{text}: **above**"
        return f"{text}: {'met' if least <= self.value <= most else '**missed**'}"


def none(name, must=None):
    """Return a figure without a case."""
    return Figure(name, np.nan, np.nan, np.nan, 0, must)


def share(name, hits, must=None):
    """Return a share with its exact binomial interval (Clopper and Pearson (1934), Biometrika 26)."""
    hits = np.asarray([hit for hit in hits if hit is not None], dtype=bool)
    k, n = int(hits.sum()), len(hits)
    if n == 0:
        return none(name, must)
    low = float(beta.ppf(0.025, k, n - k + 1)) if k else 0.0
    high = float(beta.ppf(0.975, k + 1, n - k)) if k < n else 1.0
    return Figure(name, k / n, low, high, n, must)


def statistic(name, values, take=np.mean, must=None, seed=0):
    """Return a statistic with its bootstrap interval."""
    values = np.asarray([v for v in values if v is not None and np.isfinite(v)], dtype=float)
    if not len(values):
        return none(name, must)
    rng = np.random.default_rng(seed)
    draws = [take(values[rng.integers(len(values), size=len(values))]) for _ in range(1000)]
    return Figure(name, float(take(values)), *np.quantile(draws, [0.025, 0.975]).tolist(), len(values), must)


def area(name, positive, negative, must=None):
    """Return the chance that a positive is greater than a negative (area under the ROC), by bootstrap of both."""
    a, b = np.asarray(positive, dtype=float), np.asarray(negative, dtype=float)
    if not len(a) or not len(b):
        return none(name, must)

    def above(x, y):
        return float(np.mean((x[:, None] > y[None, :]) + 0.5 * (x[:, None] == y[None, :])))

    rng = np.random.default_rng(0)
    draws = [above(rng.choice(a, len(a)), rng.choice(b, len(b))) for _ in range(500)]
    return Figure(name, above(a, b), *np.quantile(draws, [0.025, 0.975]).tolist(), len(a), must)


def calibration(name, stated, hits, weights=None, must=None, bins=5):
    """Return the expected calibration error of stated probabilities, in bins of about equal weight."""
    stated, hits = np.asarray(stated, dtype=float), np.asarray(hits, dtype=float)
    if not len(stated):
        return none(name, must)
    weights = np.ones(len(stated)) if weights is None else np.asarray(weights, dtype=float)

    def error(index):
        order = index[np.argsort(stated[index], kind="stable")]
        weight = weights[order] / weights[order].sum()
        place = np.minimum((bins * (np.cumsum(weight) - 0.5 * weight)).astype(int), bins - 1)
        gaps = np.bincount(place, weight * (stated[order] - hits[order]), bins)
        return float(np.abs(gaps).sum())

    rng = np.random.default_rng(0)
    draws = [error(rng.integers(len(stated), size=len(stated))) for _ in range(300)]
    low, high = np.quantile(draws, [0.025, 0.975]).tolist()
    return Figure(name, error(np.arange(len(stated))), low, high, len(stated), must)
