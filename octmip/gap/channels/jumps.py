"""Gauges that jump within a cell: one gauge's readings move by a step from some row on.

In each cell every gauge's residuals are whitened by what the noise remembers (so that slow noise is no step), and every
step position is fitted by least squares beside the mean:

    T_k = u_k' z / |u_k|,    u_k = L^-1 1(t >= k) less its part along L^-1 1,    z = L^-1 r,    Gamma = L L'.

max_k |T_k| beyond `JUMP` standard deviations is a jump. Source: D. M. Hawkins (1977), "Testing a sequence of
observations for a shift in location", J. Amer. Statist. Assoc. 72.

The gauge's readings of that cell are left out, and later ones have an offset of which nothing is known
(`Noise.across`): they still show how the gauge changes from load to load. A jump between two cells, or within one
reading of their border, is not seen here.
"""

from dataclasses import dataclass

import numpy as np
import scipy.linalg as linalg
from numpy.typing import NDArray
from scipy.ndimage import median_filter

from octmip.gap.campaign.campaign import Campaign
from octmip.gap.campaign.spectrum import SHORTEST, Serial, coefficients, fit

Floats = NDArray[np.float64]

JUMP = 5.0
"""Standard deviations beyond which a step is none of chance: some thousand positions are tried."""
EDGE = 2
"""Readings on either side of a jump, at least: one is an outlier."""
SHARE = 0.2
"""Share of the cells of a gauge, or of all, beyond which it is slow noise and no jump."""
KEPT = 0.8
"""Share of the series, the quietest at long periods, that say what the noise remembers."""
TYPICAL = 2.3
"""Greatest |T_k| of the typical cell of 50 white readings."""
FAR = 4.0
"""Standard deviations from the running median beyond which a reading is replaced by it."""


@dataclass(frozen=True, slots=True)
class Found:
    """A jump.

    Attributes
    ----------
    gauge, cell, row
        indices of gauge and cell, first row after it.
    size
        in the unit of the gauge's readings.
    """

    gauge: int
    cell: int
    row: int
    size: float


def jumps_in(campaign: Campaign) -> list[Found]:
    """Return the jumps, at most one for each gauge and cell."""
    whole = [k for k, cell in enumerate(campaign.cells) if len(cell.rows) >= SHORTEST]
    if not whole:
        return []
    sd = _robust_sd(campaign, whole)
    blocks = [_plain(campaign, k, sd) for k in whole]
    serial = _memory(blocks)
    steps = [_steps(block, serial) for block in blocks]
    typical = float(np.median(np.concatenate([np.abs(t).max(axis=0) for t, _ in steps])))
    limit = JUMP * max(1.0, typical / TYPICAL)
    found = []
    for k, (t, sizes) in zip(whole, steps, strict=True):
        at = np.argmax(np.abs(t), axis=0)
        for gauge in np.flatnonzero(np.abs(t).max(axis=0) > limit):
            row = int(campaign.cells[k].rows[at[gauge] + EDGE])
            found.append(Found(int(gauge), k, row, float(sizes[at[gauge], gauge] * sd[gauge])))
    return _sparse(found, len(whole), len(campaign.gauges))


def _sparse(found: list[Found], n_cells: int, n_gauges: int) -> list[Found]:
    """Return the jumps of gauges that jump seldom; none where many gauges do: that is slow noise."""
    if len(found) > max(1.0, SHARE * n_cells * n_gauges):
        return []
    counts = np.bincount([jump.gauge for jump in found], minlength=n_gauges)
    return [jump for jump in found if counts[jump.gauge] <= max(1.0, SHARE * n_cells)]


def _robust_sd(campaign: Campaign, cells: list[int]) -> Floats:
    """Return the standard deviation (n_gauges,) of one reading, the median over cells; 1 where there is none."""
    every = [campaign.readings[campaign.cells[k].rows] for k in cells]
    table = np.array([np.maximum(_sd(r), _sd(np.diff(r, axis=0)) / np.sqrt(2.0)) for r in every])
    return np.array([float(np.median(column[column > 0.0])) if (column > 0.0).any() else 1.0 for column in table.T])


def _sd(values: Floats) -> Floats:
    """Return the standard deviation (n_gauges,) of what was recorded, 0 where nothing was."""
    count = np.maximum(np.isfinite(values).sum(axis=0), 1)
    offset = values - np.nansum(values, axis=0) / count
    return np.asarray(np.sqrt(np.nansum(offset**2, axis=0) / count))


def _plain(campaign: Campaign, k: int, sd: Floats) -> Floats:
    """Return the residuals (n, n_gauges) of a cell in standard deviations, far-off readings replaced."""
    cell = campaign.cells[k]
    residual = np.nan_to_num((campaign.readings[cell.rows] - cell.mean) / sd)
    local = median_filter(residual, size=(5, 1), mode="mirror")
    plain = np.where(np.abs(residual - local) > FAR, local, residual)
    return np.asarray(plain - plain.mean(axis=0))


def _memory(blocks: list[Floats]) -> Serial:
    """Return what the noise remembers, from the series that are quietest at long periods: those without a jump."""
    squares = [coefficients(block) ** 2 for block in blocks]
    slow = np.concatenate([square[:4].sum(axis=0) for square in squares])
    limit = float(np.quantile(slow, KEPT))
    return fit([np.sqrt(square[:, square[:4].sum(axis=0) <= limit]) for square in squares])


def _steps(block: Floats, serial: Serial) -> tuple[Floats, Floats]:
    """Return T (n_positions, n_gauges) and the sizes of the steps, for positions EDGE to n - EDGE."""
    n = len(block)
    root = np.linalg.cholesky(_covariance(serial, n))
    after = np.tri(n)[:, EDGE : n - EDGE + 1]
    white = linalg.solve_triangular(root, np.column_stack([np.ones(n), after, block]), lower=True)
    one, columns, series = white[:, :1], white[:, 1 : 1 + after.shape[1]], white[:, 1 + after.shape[1] :]
    one = one / np.linalg.norm(one)
    columns = columns - one @ (one.T @ columns)
    squared = np.sum(columns**2, axis=0)[:, None]
    along = columns.T @ series
    return np.asarray(along / np.sqrt(squared)), np.asarray(along / squared)


def _covariance(serial: Serial, n: int) -> Floats:
    """Return the covariance (n, n) of readings of a cell."""
    lag = np.arange(n)
    remembering = (serial.rho[:, None] ** lag).T @ (serial.weight * serial.remembering)
    walk = serial.step_variance * np.minimum.outer(lag + 1.0, lag + 1.0)
    return np.asarray(linalg.toeplitz(remembering) + walk + float(serial.weight @ serial.white) * np.eye(n))
