"""Gauges that jump within a cell: one gauge's readings move by a step from some row on.

In each cell every gauge's residuals are whitened by what the noise remembers (so that slow noise is no step), and every
step position is fitted by least squares beside the mean:

    T_k = u_k' z / |u_k|,    u_k = L^-1 1(t >= k) less its part along L^-1 1,    z = L^-1 r,    Gamma = L L'.

max_k |T_k| beyond `JUMP` standard deviations is a jump. Source: D. M. Hawkins (1977), "Testing a sequence of
observations for a shift in location", J. Amer. Statist. Assoc. 72.

The gauge's readings of that cell are left out, and later ones have an offset of which nothing is known: they still show
how the gauge changes from load to load. A jump between two cells, or within one reading of their border, is not seen.
"""

import numpy as np
from numpy.typing import NDArray
from scipy import linalg
from scipy.ndimage import median_filter

from octmip.gap.campaign.campaign import Campaign, Fault
from octmip.gap.campaign.spectrum import SHORTEST, Serial, coefficients, fit

Floats = NDArray[np.float64]

JUMP = 5.0
"""Standard deviations beyond which a step is none of chance: some thousand positions are tried."""
EDGE = 2
"""Readings on either side of a jump, at least: one is an outlier."""
SHARE = 0.2
"""Share of the cells of a gauge, or of all, beyond which it is slow noise and no jump."""
KEPT = 0.8
"""Share of the series, the quietest at long periods, that say what the noise remembers: those without a jump."""
TYPICAL = 2.3
"""Greatest |T_k| of the typical cell of 50 white readings."""
FAR = 4.0
"""Standard deviations from the running median beyond which a reading is replaced by it."""


def jumps_in(campaign: Campaign) -> list[Fault]:
    """Return the jumps, at most one for each gauge and cell; none where many gauges do: that is slow noise."""
    cells = [cell for cell in campaign.cells if len(cell.rows) >= SHORTEST]
    if not cells:
        return []
    every = [campaign.readings[cell.rows] for cell in cells]
    sd = _robust_sd(every)
    blocks = [_plain(readings / sd) for readings in every]
    serial = _memory(blocks)
    steps = [_steps(block, serial) for block in blocks]
    greatest = np.array([np.abs(t).max(axis=0) for t, _ in steps])
    limit = JUMP * max(1.0, float(np.median(greatest)) / TYPICAL)
    far = greatest > limit
    if far.sum() > max(1.0, SHARE * far.size):
        return []
    far &= far.sum(axis=0) <= max(1.0, SHARE * len(cells))
    found = []
    for k, gauge in np.argwhere(far).tolist():
        t, sizes = steps[k]
        at, name, rows = int(np.argmax(np.abs(t[:, gauge]))), campaign.gauges[gauge], cells[k].rows
        size, first = float(sizes[at, gauge] * sd[gauge]), int(rows[at + EDGE])
        words = (
            f"Jump: gauge {name} moves by {size:+.3g} {campaign.unit_of(name)} at row {campaign.row_number(first)} "
            f"({cells[k].name}); its readings there are left out, and later ones have an unknown offset. Look at its "
            "wiring."
        )
        found.append(Fault("jump", name, rows, words, size, first))
    return found


def _robust_sd(blocks: list[Floats]) -> Floats:
    """Return the standard deviation (n_gauges,) of one reading, the median over cells; 1 where there is none."""
    table = np.array([np.maximum(_sd(r), _sd(np.diff(r, axis=0)) / np.sqrt(2.0)) for r in blocks])
    return np.array([float(np.median(column[column > 0.0])) if (column > 0.0).any() else 1.0 for column in table.T])


def _sd(values: Floats) -> Floats:
    """Return the standard deviation (n_gauges,) of what was recorded, 0 where nothing was."""
    return np.sqrt(np.nanmean(_plain_residual(values) ** 2, axis=0)) if len(values) else np.zeros(values.shape[1])


def _plain_residual(values: Floats) -> Floats:
    """Return values (n, n_gauges) less the mean of what was recorded, 0 where nothing was."""
    count = np.maximum(np.isfinite(values).sum(axis=0), 1)
    return np.asarray(np.nan_to_num(values - np.nansum(values, axis=0) / count))


def _plain(values: Floats) -> Floats:
    """Return readings (n, n_gauges) in standard deviations less their mean, far-off ones replaced."""
    residual = _plain_residual(values)
    local = median_filter(residual, size=(5, 1), mode="mirror")
    plain = np.where(np.abs(residual - local) > FAR, local, residual)
    return np.asarray(plain - plain.mean(axis=0))


def _memory(blocks: list[Floats]) -> Serial:
    """Return what the noise remembers, from the series that are quietest at long periods."""
    cosines = [coefficients(block) for block in blocks]
    slow = [(c[:4] ** 2).sum(axis=0) for c in cosines]
    limit = float(np.quantile(np.concatenate(slow), KEPT))
    return fit([c[:, power <= limit] for c, power in zip(cosines, slow, strict=True)])


def _steps(block: Floats, serial: Serial) -> tuple[Floats, Floats]:
    """Return T (n_positions, n_gauges) and the sizes of the steps, for positions EDGE to n - EDGE."""
    n = len(block)
    root = np.linalg.cholesky(_covariance(serial, n))
    after = np.tri(n)[:, EDGE : n - EDGE + 1]
    white = linalg.solve_triangular(root, np.column_stack([np.ones(n), after, block]), lower=True)
    one, columns, series = np.split(white, [1, 1 + after.shape[1]], axis=1)
    columns = columns - one @ (one.T @ columns) / float(np.sum(one**2))
    squared = np.sum(columns**2, axis=0)[:, None]
    along = columns.T @ series
    return np.asarray(along / np.sqrt(squared)), np.asarray(along / squared)


def _covariance(serial: Serial, n: int) -> Floats:
    """Return the covariance (n, n) of readings of a cell."""
    lag = np.arange(n)
    remembering = (serial.rho[:, None] ** lag).T @ (serial.weight * serial.remembering)
    walk = serial.step_variance * np.minimum.outer(lag + 1.0, lag + 1.0)
    return np.asarray(linalg.toeplitz(remembering) + walk + float(serial.weight @ serial.white) * np.eye(n))
