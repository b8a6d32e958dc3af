"""Far-off readings: means that withstand them.

Readings of a gauge are mostly normal about the mean of their cell; a share p is spread more widely, to one side (sparks
of interference) or to both:

    (1 - p) N(mu, sd^2) + p N(mu + m sd, s^2 sd^2),    mu by cell and gauge, sd and p by gauge, m and s of all.

The maximum of the likelihood is found by expectation and maximisation; w is the probability that a reading belongs to
the narrow part. The mean mu solves sum psi = 0 with psi = w r, and to first order it is the plain mean of the values

    y* = mu + sd psi / mean(psi'),

which take the readings' place: their means are the robust means, and their scatter, across gauges and in time, is that
of robust means. Gauges without a reading that far exceeds what normal noise gives stay as they are, at no loss.

Skewed noise is no contamination: a wide part to one side counts only where it is rare and far. Where far readings are
many and lie to one side, readings stay as they are, since skewed noise leaves the plain mean unbiased.

Source: A. P. Dempster, N. M. Laird, D. B. Rubin (1977), "Maximum likelihood from incomplete data via the EM
algorithm", J. Royal Statist. Soc. B 39; P. J. Huber (1981), "Robust Statistics", section 1.5 (pseudo-values).
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import median_filter
from scipy.stats import norm

from octmip.gap.campaign.campaign import Campaign

Floats = NDArray[np.float64]

CHANCE = 0.005
"""Probability that normal noise has one reading of the campaign as far off as is asked of an outlier."""
LOCAL = 0.7
"""Share of that distance that it also has from its neighbours: slow noise and jumps take them along."""
FEWEST = 5
"""Readings of a cell that show an outlier."""
RARE, APART = 0.06, 3.0
"""Greatest share, and least distance in standard deviations, of far readings to one side."""
SKEWED, BODY = 0.35, (2.0, 3.5)
"""Imbalance of the two sides of the body of the noise, and where it is counted [sd], beyond which noise is skewed."""
LOPSIDED = 3.0
"""Standard deviations of the count of far readings on either side beyond which they lie to one side."""
PASSES = 25
"""Rounds of expectation and maximisation; the share has settled to 1e-3 of itself after 15."""
LEAST_SLOPE = 0.5
"""Least mean of psi': noise that is mostly far-off readings is no noise with outliers."""


@dataclass(frozen=True, slots=True, eq=False)
class Robust:
    """Readings whose plain means are robust means.

    Attributes
    ----------
    readings
        (n_rows, n_gauges) in their units.
    share
        by gauge with far-off readings, their share.
    is_one_sided
        whether they lie to one side: outliers; else the noise has heavy tails.
    """

    readings: Floats
    share: Mapping[str, float]
    is_one_sided: bool = False


@dataclass(frozen=True, slots=True, eq=False)
class _Mixture:
    """Residuals (n_rows, n_gauges) in standard deviations of the narrow part, and the wide part's mean and sd."""

    residual: Floats
    centre: Floats
    sd: Floats
    share: Floats
    mean: float
    spread: float

    def narrow(self) -> Floats:
        """Return w (n_rows, n_gauges), 0 where nothing was recorded."""
        r = self.residual
        log_narrow = np.log1p(-self.share) - 0.5 * r**2
        log_wide = np.log(self.share) - 0.5 * ((r - self.mean) / self.spread) ** 2 - np.log(self.spread)
        return np.asarray(np.nan_to_num(1.0 / (1.0 + np.exp(np.clip(log_wide - log_narrow, -60.0, 60.0)))))


def robust(campaign: Campaign) -> Robust:
    """Return the readings with those of gauges with outliers replaced."""
    readings = np.array(campaign.readings)
    number = np.full(len(readings), -1)
    for k, cell in enumerate(campaign.cells):
        if len(cell.rows) >= FEWEST:
            number[cell.rows] = k
    rows = np.flatnonzero(number >= 0)
    if not rows.size:
        return Robust(readings, {})
    cell_of = np.unique(number[rows], return_inverse=True)[1]
    scale = _scale(readings[rows], cell_of)[:, None]
    every = readings[rows] / scale
    centre, sd = _start(every, cell_of)
    far = _far((every - centre[cell_of]) / sd, cell_of)
    gauges = np.flatnonzero(far.any(axis=0))
    if not gauges.size or _is_skewed((every - centre[cell_of]) / sd):
        return Robust(readings, {})
    fitted = _fitted(every[:, gauges], cell_of, far[:, gauges])
    if fitted is None:
        return Robust(readings, {})
    values = every[:, gauges]
    readings[np.ix_(rows, gauges)] = _pseudo_values(fitted, values) * scale
    share = 1.0 - fitted.narrow().sum(axis=0) / np.isfinite(values).sum(axis=0)
    by_name = {campaign.gauges[k]: float(s) for k, s in zip(gauges, share, strict=True)}
    return Robust(readings, by_name, fitted.mean != 0.0)


def _far(residual: Floats, cell_of: NDArray[np.int64]) -> NDArray[np.bool_]:
    """Return which readings lie far from their cell's median and from their neighbours; residuals are in sd."""
    limit = float(norm.isf(CHANCE / 2.0 / max(1, int(np.isfinite(residual).sum()))))
    far = np.abs(np.nan_to_num(residual)) > limit
    for k in np.unique(cell_of[far.any(axis=1)]):
        block = np.nan_to_num(residual[cell_of == k])
        local = median_filter(block, size=(5, 1), mode="mirror")
        far[cell_of == k] &= np.abs(block - local) > LOCAL * limit
    return far


def _is_skewed(residual: Floats) -> bool:
    """Return whether the body of the noise, its far readings left out, leans to one side: then no reading is wrong."""
    r = np.nan_to_num(residual)
    up, down = (int(((side > BODY[0]) & (side < BODY[1])).sum()) for side in (r, -r))
    total = up + down
    return abs(up - down) > max(SKEWED * total, LOPSIDED * float(np.sqrt(total)))


def _scale(values: Floats, cell_of: NDArray[np.int64]) -> Floats:
    """Return the factor (n_rows,) by which the readings of each row's cell scatter more than those of the typical."""
    centre, sd = _start(values, cell_of)
    distance = np.abs(values - centre[cell_of]) / sd
    seen = np.array([_nanmedian(distance[cell_of == k].reshape(-1, 1))[0] for k in range(len(centre))])
    seen = np.where(np.isfinite(seen) & (seen > 0.0), seen, np.nan)
    if np.isnan(seen).all():  # one reading a cell, or sd of nothing: no cell is known to scatter more
        return np.ones(len(values))
    return np.where(np.isnan(seen), 1.0, seen / np.nanmedian(seen))[cell_of]


def _start(values: Floats, cell_of: NDArray[np.int64]) -> tuple[Floats, Floats]:
    """Return the medians (n_cells, n_gauges) and the sd (n_gauges,) from the median absolute residual."""
    n_cells = int(cell_of.max()) + 1
    centre = np.array([_nanmedian(values[cell_of == k]) for k in range(n_cells)])
    small = np.sqrt(len(values) / max(1, len(values) - n_cells))
    sd = 1.4826 * small * _nanmedian(np.abs(values - centre[cell_of]))
    return centre, np.where(np.isfinite(sd) & (sd > 0.0), sd, np.inf)


def _nanmedian(values: Floats) -> Floats:
    if np.isfinite(values).all():
        return np.asarray(np.median(values, axis=0))
    seen = np.isfinite(values).any(axis=0)
    found = np.full(values.shape[1], np.nan)
    found[seen] = np.nanmedian(values[:, seen], axis=0)
    return found


def _fitted(values: Floats, cell_of: NDArray[np.int64], far: NDArray[np.bool_]) -> _Mixture | None:
    """Return the mixture; None where far readings are too many to one side to be no noise."""
    centre, sd = _start(values, cell_of)
    residual = (values - centre[cell_of]) / sd
    up, down = int((far & (residual > 0)).sum()), int((far & (residual < 0)).sum())
    share = np.clip(far.sum(axis=0) / np.isfinite(values).sum(axis=0), 1e-3, 0.1)
    spread = float(max(2.0, residual[far].std()))
    if min(up, down) > 0 and abs(up - down) <= LOPSIDED * np.sqrt(up + down):
        return _settled(values, cell_of, _Mixture(residual, centre, sd, share, 0.0, max(3.0, spread)), False)
    found = _settled(values, cell_of, _Mixture(residual, centre, sd, share, float(residual[far].mean()), spread), True)
    return found if float(found.share.mean()) <= RARE and abs(found.mean) >= APART else None


def _settled(values: Floats, cell_of: NDArray[np.int64], mixture: _Mixture, is_one_sided: bool) -> _Mixture:
    """Return the maximum of the likelihood near a mixture; the wide part's mean stays 0 unless it lies to one side."""
    n_cells = len(mixture.centre)
    member = (cell_of[:, None] == np.arange(n_cells)).astype(np.float64)
    recorded, filled = np.isfinite(values), np.nan_to_num(values)
    for _ in range(PASSES):
        w = mixture.narrow() * recorded
        wide, r = recorded - w, np.nan_to_num(mixture.residual)
        total = max(float(wide.sum()), 1e-9)
        mean = float((wide * r).sum()) / total if is_one_sided else 0.0
        spread = max(1.0, float(np.sqrt((wide * (r - mean) ** 2).sum() / total)))
        weight = member.T @ w
        centre = (member.T @ (w * filled)) / np.maximum(weight, 1e-9)
        offset = values - centre[cell_of]
        freedom = np.maximum(w.sum(axis=0) - (weight > 0.5).sum(axis=0), 1.0)
        sd = np.sqrt(np.nansum(w * offset**2, axis=0) / freedom)
        share = np.clip(wide.sum(axis=0) / recorded.sum(axis=0), 1e-4, 0.3)
        mixture = _Mixture(offset / sd, centre, sd, share, mean, spread)
    return mixture


def _pseudo_values(mixture: _Mixture, values: Floats) -> Floats:
    """Return the values (n_rows, n_gauges) whose plain means are the mixture's."""
    r, w = mixture.residual, mixture.narrow()
    slope = w + r * w * (1.0 - w) * ((r - mixture.mean) / mixture.spread**2 - r)
    mean_slope = np.maximum(np.nansum(slope, axis=0) / np.isfinite(values).sum(axis=0), LEAST_SLOPE)
    centre = values - r * mixture.sd
    return np.asarray(centre + mixture.sd * r * w / mean_slope)
