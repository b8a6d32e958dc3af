"""Figures with their intervals: shares, means, areas under curves, calibration."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
from scipy.stats import beta

from femlib.arrays import FloatArray, IntArray

Must = tuple[float, float]
"""The least and the most that a figure owes."""


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
    must: Must | None = None

    def owed(self) -> str:
        """Return what is owed in words."""
        if self.must is None:
            return ""
        least, most = self.must
        if np.isinf(most):
            return f">= {least:g}"
        return f"<= {most:g}" if np.isinf(least) else f"{least:g}-{most:g}"

    def words(self) -> str:
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


def none(name: str, must: Must | None = None) -> Figure:
    """Return a figure without a case."""
    return Figure(name, np.nan, np.nan, np.nan, 0, must)


def share(name: str, hits: Iterable[bool | None], must: Must | None = None) -> Figure:
    """Return a share with its exact binomial interval (Clopper and Pearson (1934), Biometrika 26)."""
    told = np.asarray([hit for hit in hits if hit is not None], dtype=bool)
    k, n = int(told.sum()), len(told)
    if n == 0:
        return none(name, must)
    low = float(beta.ppf(0.025, k, n - k + 1)) if k else 0.0
    high = float(beta.ppf(0.975, k + 1, n - k)) if k < n else 1.0
    return Figure(name, k / n, low, high, n, must)


tenth = partial(np.quantile, q=0.1)
"""The value that a tenth lies below, for `statistic`."""


def statistic(
    name: str,
    values: Iterable[float | None],
    take: Callable[..., Any] = np.mean,
    must: Must | None = None,
) -> Figure:
    """Return a statistic with its bootstrap interval; `take` has an axis, as `np.mean` has."""
    finite = np.asarray([v for v in values if v is not None and np.isfinite(v)], dtype=float)
    if not len(finite):
        return none(name, must)
    rng = np.random.default_rng(0)
    draws = take(finite[rng.integers(len(finite), size=(1000, len(finite)))], axis=1)
    low, high = np.quantile(draws, [0.025, 0.975]).tolist()
    return Figure(name, float(take(finite)), low, high, len(finite), must)


def area(name: str, positive: Sequence[float], negative: Sequence[float], must: Must | None = None) -> Figure:
    """Return the chance that a positive is greater than a negative (area under the ROC), by bootstrap of both."""
    a, b = np.asarray(positive, dtype=float), np.asarray(negative, dtype=float)
    if not len(a) or not len(b):
        return none(name, must)

    def above(x: FloatArray, y: FloatArray) -> float:
        return float(np.mean((x[:, None] > y[None, :]) + 0.5 * (x[:, None] == y[None, :])))

    rng = np.random.default_rng(0)
    draws = [above(rng.choice(a, len(a)), rng.choice(b, len(b))) for _ in range(500)]
    low, high = np.quantile(draws, [0.025, 0.975]).tolist()
    return Figure(name, above(a, b), low, high, len(a), must)


def calibration(
    name: str,
    stated: Sequence[float],
    hits: Sequence[bool],
    weights: Sequence[float] | None = None,
    must: Must | None = None,
    bins: int = 5,
) -> Figure:
    """Return the expected calibration error of stated probabilities, in bins of about equal weight."""
    p, is_hit, n = np.asarray(stated, dtype=float), np.asarray(hits, dtype=float), len(stated)
    if not n:
        return none(name, must)
    of_case = np.ones(n) if weights is None else np.asarray(weights, dtype=float)

    def error(index: IntArray) -> float:
        order = index[np.argsort(p[index], kind="stable")]
        weight = of_case[order] / of_case[order].sum()
        place = np.minimum((bins * (np.cumsum(weight) - 0.5 * weight)).astype(int), bins - 1)
        gaps = np.bincount(place, weight * (p[order] - is_hit[order]), bins)
        return float(np.abs(gaps).sum())

    rng = np.random.default_rng(0)
    draws = [error(rng.integers(n, size=n)) for _ in range(300)]
    low, high = np.quantile(draws, [0.025, 0.975]).tolist()
    return Figure(name, error(np.arange(n)), low, high, n, must)


def table(title: str, columns: Mapping[str, Sequence[Figure]]) -> str:
    """Return figures in Markdown: one row per name, what it owes, then one column per set of cases."""
    named = {column: {row.name: row for row in rows} for column, rows in columns.items()}
    names = dict.fromkeys(name for rows in named.values() for name in rows)
    owed = {name: next(rows[name].owed() for rows in named.values() if name in rows) for name in names}
    has_must = any(owed.values())
    lines = [f"| {title} | {'must | ' * has_must}{' | '.join(columns)} |", "|---|" + "---|" * (has_must + len(columns))]
    for name in names:
        cells = [rows[name].words() if name in rows else "" for rows in named.values()]
        lines.append(f"| {name} | {owed[name] + ' | ' if has_must else ''}{' | '.join(cells)} |")
    return "\n".join(lines)
