"""Serial correlation of repeats, from their pooled spectrum, and what it makes of the variance of means.

Repeats of one cell are mean + white noise + a part that remembers: AR(1) with correlation rho, or a random walk. The
mean is unknown, so only the contrasts within a cell speak. In the cosine basis h_j, j = 1 .. n - 1, which is orthogonal
to the mean, their variances are known exactly, so no bias comes from taking the means off:

    d_j = 1 + 2 sum_k rho^k c_jk,    c_jk = ((n - k) cos(pi j k / n) - sin(pi j k / n) / sin(pi j / n)) / n    AR(1)
    d_j = 1 / (4 sin^2(pi j / 2 n))                                                                      random walk

The squared coefficients, summed over all series of one length, are fitted by the likelihood of independent normal
coefficients on a grid of rho and of the share of the remembering part. The posterior over the grid is kept: the
variance of a mean is its posterior mean, so that what few series leave open is carried on.

Source: A. M. Yaglom (1987), "Correlation Theory of Stationary and Related Random Functions"; P. Whittle (1953),
"Estimation and information in stationary time series", Arkiv Mat. 2 (the likelihood); the variance of the mean of an
AR(1) series is T. W. Anderson (1971), "The Statistical Analysis of Time Series", section 8.2.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
import scipy.fft
from numpy.typing import NDArray

Floats = NDArray[np.float64]

RHOS = np.array([0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.75, 0.8, 0.85, 0.9, 0.93, 0.95])
"""Correlations of successive readings on the grid; a stronger one is a walk to series of some ten readings."""
SHARES = np.array([0.02, 0.05, 0.1, 0.15, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 0.95, 1.0])
"""Shares of the variance of a reading that remember, on the grid."""
STEPS = np.geomspace(1e-5, 1e2, 43)
"""Variance of one step of the walk over that of the white part, on the grid."""
SINGLE = (0.8, 0.15, 0.05)
"""Probability of white noise, of AR(1) beside it and of a walk beside it in what single gauges have."""
SHARED = (0.5, 0.25, 0.25)
"""The same in what gauges share: supplies and temperatures wander."""
SHORTEST = 8
"""Readings of a series that says something of its memory."""
MEMORY = 1000
"""Lags beyond which the strongest correlation of the grid is below 1e-12."""
FINE = 200
"""Cosines that are kept one by one; those of shorter period are averaged in bands."""


@dataclass(frozen=True, slots=True, eq=False)
class Spectrum:
    """Squared cosine coefficients of the series of one length.

    Attributes
    ----------
    length
        readings in each series.
    power
        (n_bands,) mean squared coefficient.
    count
        (n_bands,) independent coefficients behind each.
    """

    length: int
    power: Floats
    count: Floats


@dataclass(frozen=True, slots=True, eq=False)
class Serial:
    """Posterior of white noise with AR(1) and a random walk; all variances in units of the series'.

    Attributes
    ----------
    weight, white, remembering, rho, walk
        (n_points,) probability, variance of the white part, of the AR(1) part, its correlation, and the variance of one
        step of the walk.
    """

    weight: Floats
    white: Floats
    remembering: Floats
    rho: Floats
    walk: Floats

    @property
    def variance(self) -> float:
        """Of one reading, the walk left out."""
        return float(self.weight @ (self.white + self.remembering))

    @property
    def lag1(self) -> float:
        """Correlation of successive readings, the walk left out."""
        return float(self.weight @ (self.remembering * self.rho)) / self.variance

    @property
    def step_variance(self) -> float:
        """Expected variance of one step of the walk."""
        return float(self.weight @ self.walk)

    @property
    def white_probability(self) -> float:
        """Probability that readings remember nothing."""
        return float(self.weight[(self.remembering == 0.0) & (self.walk == 0.0)].sum())

    @property
    def walk_probability(self) -> float:
        """Probability that a part wanders."""
        return float(self.weight[self.walk > 0.0].sum())

    def of_mean(self, n: int) -> float:
        """Return the variance of the mean of n successive readings, the walk left out."""
        sums = self.white + self.remembering * inflation_of(self.rho, n)
        return float(self.weight @ sums) / n

    def between(self, n: int, m: int, distance: int) -> float:
        """Return the covariance of the means of n readings and of m that begin `distance` after the first of them.

        The two do not overlap: distance is n where the one follows the other at once.
        """
        rho = self.rho
        blocks = (1.0 - rho**n) * (1.0 - rho**m) / (1.0 - rho) ** 2
        return float(self.weight @ (self.remembering * rho ** (distance - n + 1) * blocks)) / (n * m)


WHITE = Serial(np.ones(1), np.ones(1), np.zeros(1), np.zeros(1), np.zeros(1))
"""Readings that remember nothing."""


def inflation_of(rho: Floats, n: int) -> Floats:
    """Return n times the variance of a mean of n AR(1) readings of unit variance."""
    return np.asarray((1.0 + rho) / (1.0 - rho) - 2.0 * rho * (1.0 - rho**n) / (n * (1.0 - rho) ** 2))


def coefficients(series: Floats) -> Floats:
    """Return the cosine coefficients (n - 1, ...) of series (n, ...), without that of the mean."""
    return np.asarray(scipy.fft.dct(series, type=2, norm="ortho", axis=0))[1:]


def spectra_of(blocks: Sequence[Floats], independent: float = 1.0, has_trend: bool = True) -> list[Spectrum]:
    """Return the spectra of blocks (n - 1, n_series) of squared coefficients, by the length n of their series.

    `independent` is the number of independent series behind each of a block's: 1, less where series share noise. The
    first cosine, nearly a straight line, counts where `has_trend`.
    """
    lengths = sorted({len(block) + 1 for block in blocks if len(block) + 1 >= SHORTEST})
    found = []
    for n in lengths:
        squares = np.concatenate([block for block in blocks if len(block) + 1 == n], axis=1)
        band = bands(n)
        width = np.diff(np.append(band, n - 1))
        count = width * squares.shape[1] * independent
        count[0] *= has_trend
        found.append(Spectrum(n, np.add.reduceat(squares.mean(axis=1), band) / width, count))
    return found


@lru_cache(maxsize=256)
def bands(n: int) -> NDArray[np.int64]:
    """Return the first cosine, counted from 0, of every band of a series of n readings."""
    if n - 1 <= FINE:
        return np.arange(n - 1)
    wide = np.unique(np.geomspace(FINE // 2, n - 1, FINE // 2, endpoint=False).astype(np.int64))
    return np.concatenate([np.arange(FINE // 2), wide])


@lru_cache(maxsize=256)
def _shapes(n: int) -> tuple[Floats, Floats]:
    """Return d (n_rhos, n_bands) of AR(1) of unit variance, and d (n_bands,) of a walk of unit steps."""
    first = bands(n)
    j = 1.0 + 0.5 * (first + np.append(first[1:], n - 1) - 1.0)  # the middle of each band
    lag = np.arange(1, min(n - 1, MEMORY) + 1)
    angle = np.pi * np.outer(j, lag) / n
    c = ((n - lag) * np.cos(angle) - np.sin(angle) / np.sin(np.pi * j / n)[:, None]) / n
    remembering = 1.0 + 2.0 * (RHOS[:, None] ** lag) @ c.T
    return remembering, 0.25 / np.sin(np.pi * j / (2.0 * n)) ** 2


def fit(spectra: Sequence[Spectrum], prior: tuple[float, float, float] = SINGLE) -> Serial:
    """Return the posterior of the serial correlation that the spectra leave; white where there are none."""
    usable = [s for s in spectra if float(s.count @ s.power) > 0.0]
    if not usable:
        return WHITE
    white, remembering, rho, walk, kind = _grid()
    logs, left, degrees = np.zeros(len(kind)), np.zeros(len(kind)), 0.0
    for s in usable:
        shape = _expected(s.length)
        logs += np.log(shape) @ s.count
        left += (1.0 / shape) @ (s.count * s.power)
        degrees += float(s.count.sum())
    scale = left / degrees
    likelihood = -0.5 * (degrees * np.log(scale) + logs)
    weight = (np.array(prior) / np.bincount(kind))[kind] * np.exp(likelihood - likelihood.max())
    weight /= weight.sum()
    scale *= degrees / max(degrees - 2.0, 1.0)  # mean of the inverse gamma posterior
    keep = weight > 1e-6
    white, remembering, walk = ((scale * part)[keep] for part in (white, remembering, walk))
    return Serial(weight[keep] / weight[keep].sum(), white, remembering, rho[keep], walk)


@lru_cache(maxsize=1)
def _grid() -> tuple[Floats, Floats, Floats, Floats, NDArray[np.int64]]:
    """Return white, remembering, rho, walk and kind (n_points,) of the grid; kind 0 is white, 1 AR(1), 2 a walk."""
    rho, share = (part.ravel() for part in np.meshgrid(RHOS, SHARES, indexing="ij"))
    none, steps = np.zeros(1), np.zeros(len(STEPS))
    white = np.concatenate([np.ones(1), 1.0 - share, np.ones(len(STEPS))])
    remembering = np.concatenate([none, share, steps])
    rhos = np.concatenate([none, rho, steps])
    walk = np.concatenate([none, np.zeros(len(rho)), STEPS])
    kind = np.repeat([0, 1, 2], [1, len(rho), len(STEPS)])
    return white, remembering, rhos, walk, kind


@lru_cache(maxsize=64)
def _expected(n: int) -> Floats:
    """Return the expected squared coefficients (n_points, n_bands) of every point of the grid."""
    ar, wandering = _shapes(n)
    white, remembering, rho, walk, _ = _grid()
    row = np.searchsorted(RHOS, np.maximum(rho, RHOS[0]))
    return np.asarray(white[:, None] + remembering[:, None] * ar[row] + walk[:, None] * wandering)


def without_walk(serial: Serial) -> Serial:
    """Return the posterior given that nothing wanders; the same where nothing else is left."""
    still = serial.walk == 0.0
    if still.all() or not still.any():
        return serial
    return given(serial, still)


def given(serial: Serial, wanted: NDArray[np.bool_]) -> Serial:
    """Return the posterior given that one of the `wanted` points (n_points,) holds."""
    weight = serial.weight[wanted] / serial.weight[wanted].sum()
    return Serial(weight, serial.white[wanted], serial.remembering[wanted], serial.rho[wanted], serial.walk[wanted])


def expected(serial: Serial, n: int) -> Floats:
    """Return the posterior mean of the expected squared coefficients (n_bands,) of series of n readings."""
    ar, wandering = _shapes(n)
    row = np.searchsorted(RHOS, np.maximum(serial.rho, RHOS[0]))
    shapes = serial.white[:, None] + serial.remembering[:, None] * ar[row] + serial.walk[:, None] * wandering
    return np.asarray(serial.weight @ shapes)
