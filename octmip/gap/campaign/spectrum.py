"""Serial correlation of repeats, from their pooled spectrum, and what it makes of the variance of means.

Repeats of one cell are mean + white noise + a part that remembers: AR(1) with correlation rho, or a random walk. The
mean is unknown, so only the contrasts within a cell speak. In the cosine basis h_j, j = 1 .. n - 1, which is orthogonal
to the mean, their variances are known exactly, so no bias comes from taking the means off:

    d_j = 1 + 2 sum_k rho^k c_jk,    c_jk = ((n - k) cos(pi j k / n) - sin(pi j k / n) / sin(pi j / n)) / n    AR(1)
    d_j = 1 / (4 sin^2(pi j / 2 n))                                                                      random walk

The squared coefficients are fitted by the likelihood of independent normal coefficients on a grid of rho and of the
share of the remembering part. The posterior over the grid is kept: the variance of a mean is its posterior mean, so
that what few series leave open is carried on.

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
"""Probability of white noise, of AR(1) beside it and of a walk beside it in what single gauges have.

At .15 for a walk a faint pattern that no library holds was taken for one (docs/gap/noise.md); at .05 one of five sound
wings with a mild walk beside a calm run was accused."""
SHARED = (0.5, 0.25, 0.25)
"""The same in what gauges share: supplies and temperatures wander."""
SHORTEST = 8
"""Readings of a series that says something of its memory."""


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

    def expected(self, n: int) -> Floats:
        """Return the posterior mean of the expected squared coefficients (n - 1,) of series of n readings."""
        remembering, wandering = _shapes(n)
        row = np.searchsorted(RHOS, np.maximum(self.rho, RHOS[0]))
        weighed = np.bincount(row, self.weight * self.remembering, len(RHOS))
        return np.asarray(self.weight @ self.white + weighed @ remembering + self.step_variance * wandering)

    def given(self, wanted: NDArray[np.bool_]) -> "Serial":
        """Return the posterior given that one of the `wanted` points (n_points,) holds."""
        weight = self.weight[wanted] / self.weight[wanted].sum()
        return Serial(weight, self.white[wanted], self.remembering[wanted], self.rho[wanted], self.walk[wanted])


WHITE = Serial(np.ones(1), np.ones(1), np.zeros(1), np.zeros(1), np.zeros(1))
"""Readings that remember nothing."""


def inflation_of(rho: Floats, n: int) -> Floats:
    """Return n times the variance of a mean of n AR(1) readings of unit variance."""
    return np.asarray((1.0 + rho) / (1.0 - rho) - 2.0 * rho * (1.0 - rho**n) / (n * (1.0 - rho) ** 2))


def coefficients(series: Floats) -> Floats:
    """Return the cosine coefficients (n - 1, ...) of series (n, ...), without that of the mean."""
    return np.asarray(scipy.fft.dct(series, type=2, norm="ortho", axis=0))[1:]


def fit(cosines: Sequence[Floats], prior: tuple[float, float, float] = SINGLE, *, has_trend: bool = True) -> Serial:
    """Return the posterior that coefficients (n - 1, n_series) leave; white where there are none.

    The first cosine, nearly a straight line, counts where `has_trend`.
    """
    usable = [c for c in cosines if len(c) + 1 >= SHORTEST and c.any()]
    if not usable:
        return WHITE
    white, remembering, rho, walk, kind = _grid()
    logs, left, degrees = np.zeros(len(kind)), np.zeros(len(kind)), 0
    for n in sorted({len(c) + 1 for c in usable}):
        squares = np.concatenate([c**2 for c in usable if len(c) + 1 == n], axis=1)[0 if has_trend else 1 :]
        shape = _expected(n)[:, 0 if has_trend else 1 :]
        logs += squares.shape[1] * np.log(shape).sum(axis=1)
        left += (1.0 / shape) @ squares.sum(axis=1)
        degrees += squares.size
    scale = left / degrees
    likelihood = -0.5 * (degrees * np.log(scale) + logs)
    weight = (np.array(prior) / np.bincount(kind))[kind] * np.exp(likelihood - likelihood.max())
    weight /= weight.sum()
    scale *= degrees / max(degrees - 2.0, 1.0)  # mean of the inverse gamma posterior
    keep = weight > 1e-6
    white, remembering, walk = ((scale * part)[keep] for part in (white, remembering, walk))
    return Serial(weight[keep] / weight[keep].sum(), white, remembering, rho[keep], walk)


@lru_cache(maxsize=64)
def _shapes(n: int) -> tuple[Floats, Floats]:
    """Return d (n_rhos, n - 1) of AR(1) of unit variance, and d (n - 1,) of a walk of unit steps."""
    angle = np.pi * np.arange(1, n) / n
    z = RHOS[:, None] * np.exp(1j * angle)
    powers = z * (1.0 - z ** (n - 1)) / (1.0 - z)  # sum of z^k, k = 1 .. n - 1
    moments = z * (1.0 - n * z ** (n - 1) + (n - 1) * z**n) / (1.0 - z) ** 2  # sum of k z^k
    remembering = 1.0 + 2.0 * (powers.real - moments.real / n - powers.imag / (n * np.sin(angle)))
    return remembering, 0.25 / np.sin(0.5 * angle) ** 2


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


@lru_cache(maxsize=16)
def _expected(n: int) -> Floats:
    """Return the expected squared coefficients (n_points, n - 1) of every point of the grid."""
    ar, wandering = _shapes(n)
    white, remembering, rho, walk, _ = _grid()
    row = np.searchsorted(RHOS, np.maximum(rho, RHOS[0]))
    return np.asarray(white[:, None] + remembering[:, None] * ar[row] + walk[:, None] * wandering)
