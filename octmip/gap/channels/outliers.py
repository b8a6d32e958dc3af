"""Far-off readings: they are left out.

A reading that lies farther from the median of its cell than one of normal noise does, and from its neighbours, is none
of the noise. Gauges without one stay as they are.

Skewed noise is no contamination: where far readings are many and lie to one side, or the body of the noise leans to one
side, readings stay as they are, since skewed noise leaves the plain mean unbiased.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import median_filter
from scipy.stats import t

from octmip.gap.campaign.campaign import Campaign
from octmip.gap.campaign.display import steps_of

Floats = NDArray[np.float64]

EFFICIENCY = 0.37
"""Readings of which a standard deviation is as sure as of one whose median distance is known."""
CHANCE = 0.005
"""Probability that normal noise has one reading of the campaign as far off as is asked of an outlier."""
LOCAL = 0.7
"""Share of that distance that it also has from its neighbours: slow noise and jumps take them along."""
REACH = 3.5
"""Standard deviations beyond which the other readings go, too, where some are far off: most of these are no noise."""
FEWEST = 5
"""Readings of a cell that show an outlier."""
RARE, APART = 0.06, 3.0
"""Greatest share, and least distance in standard deviations, of far readings to one side."""
SKEWED, BODY = 0.35, (2.0, 3.5)
"""Imbalance of the two sides of the body of the noise, and where it is counted [sd], beyond which noise is skewed."""
LOPSIDED = 3.0
"""Standard deviations of the count of far readings on either side beyond which they lie to one side."""
SHOWN = 3.0
"""Steps of a display within which no reading is far off: the medians of a coarse one say little of its noise."""


@dataclass(frozen=True, slots=True, eq=False)
class Robust:
    """Readings without those that are far off.

    Attributes
    ----------
    readings
        (n_rows, n_gauges) in their units, NaN of what is left out.
    share
        by gauge with far-off readings, their share.
    is_one_sided
        whether they lie to one side: outliers; else the noise has heavy tails.
    """

    readings: Floats
    share: Mapping[str, float]
    is_one_sided: bool = False


def robust(campaign: Campaign) -> Robust:
    """Return the readings of a campaign without those that are far off."""
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
    far &= np.abs(every - centre[cell_of]) * scale > SHOWN * steps_of(campaign)
    nearer = far.any(axis=0) & (np.abs(every - centre[cell_of]) > REACH * sd)
    gauges = np.flatnonzero(far.any(axis=0))
    if not gauges.size or _is_skewed((every - centre[cell_of]) / sd):
        return Robust(readings, {})
    residual, own = (every - centre[cell_of])[:, gauges] / sd[gauges], far[:, gauges]
    up, down = int((own & (residual > 0)).sum()), int((own & (residual < 0)).sum())
    share = own.sum(axis=0) / np.isfinite(residual).sum(axis=0)
    is_one_sided = min(up, down) == 0 or abs(up - down) > LOPSIDED * np.sqrt(up + down)
    if is_one_sided and (float(share.mean()) > RARE or abs(float(residual[own].mean())) < APART):
        return Robust(readings, {})
    readings[rows] = np.where(far | nearer, np.nan, readings[rows])
    by_name = {campaign.gauges[k]: float(s) for k, s in zip(gauges, share, strict=True)}
    return Robust(readings, by_name, is_one_sided)


def _far(residual: Floats, cell_of: NDArray[np.int64]) -> NDArray[np.bool_]:
    """Return which readings lie far from their cell's median and from their neighbours; residuals are in sd."""
    recorded = np.isfinite(residual)
    freedom = EFFICIENCY * np.maximum(1, recorded.sum(axis=0) - len(np.unique(cell_of)))
    limit = t.isf(CHANCE / 2.0 / max(1, int(recorded.sum())), freedom)
    far = np.abs(np.nan_to_num(residual)) > limit
    for k in np.unique(cell_of[far.any(axis=1)]):
        block = np.nan_to_num(residual[cell_of == k])
        local = median_filter(block, size=(5, 1), mode="mirror")
        far[cell_of == k] &= np.abs(block - local) > LOCAL * limit
    return np.asarray(far)


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
