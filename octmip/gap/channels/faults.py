"""Faults of single channels: stuck, clipped, jumped.

The same number again and again where noise would change it is a stuck channel, or an end of the range.

A reading falls into the most probable step of its converter with probability p = erf(step / (2 sqrt(2) sd)); a run of m
equal readings by chance has a probability of at most n p^(m-1), n the number of readings. Runs less probable than
`CHANCE` are readings of a channel that stands still, always or for a time. Coarse steps repeat any reading: p is near
1, and no run is long enough.

Continuous noise seldom repeats its extreme reading. A gauge whose greatest (or least) reading stands in the table at
least `FEWEST_AT_RAIL` times, and more than twice as often as the next one, has met the end of its range. The mean of
such a cell is biased toward the inside by an amount that depends on what lies beyond, so that gauge's readings of that
cell are left out.

Gauges that jump within a cell: one gauge's readings move by a step from some row on.

In each cell every gauge's residuals are whitened by what the noise remembers (so that slow noise is no step), and every
step position is fitted by least squares beside the mean:

    T_k = u_k' z / |u_k|,    u_k = L^-1 1(t >= k) less its part along L^-1 1,    z = L^-1 r,    Gamma = L L'.

max_k |T_k| beyond `JUMP` standard deviations is a jump. Source: D. M. Hawkins (1977), "Testing a sequence of
observations for a shift in location", J. Amer. Statist. Assoc. 72.

The gauge's readings of that cell are left out, and later ones have an offset of which nothing is known: they still show
how the gauge changes from load to load. A jump between two cells, or within one reading of their border, is not seen.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy import linalg
from scipy.ndimage import median_filter
from scipy.special import erf

from octmip.gap.campaign.campaign import Campaign, Cell, Fault
from octmip.gap.campaign.noise_estimate import least_variance, quantisation_step
from octmip.gap.campaign.spectrum import SHORTEST, Serial, coefficients, fit
from octmip.twin import Load, amounts_of

CHANCE = 1e-6
"""Probability below which equal readings are no chance."""
LEAST_EQUAL = 8
"""Equal readings that make a run, where it is not a whole cell: slow channels hold a reading for a few rows."""
LEAST_OF_A_CELL = 4
"""Equal readings that make a run where they are a whole cell."""
QUIET = 3.0
"""Factor by which one channel may be quieter than the typical one."""
FEWEST_AT_RAIL = 4
"""Equal extreme readings that make an end of the range."""


def stuck_in(campaign: Campaign) -> list[Fault]:
    """Return what stands still, one fault per channel."""
    units = np.array([campaign.unit_of(name) for name in campaign.gauges])
    found, spreads = [], campaign.spreads()
    for unit in dict.fromkeys(units.tolist()):
        gauges = np.flatnonzero(units == unit)
        scattering = spreads[:, gauges] ** 2 > least_variance(campaign.readings[:, gauges]).max()
        if scattering.any():
            sd = float(np.median(spreads[:, gauges][scattering]))
            step = quantisation_step(campaign.readings[:, gauges])
            found += [fault for k in gauges.tolist() for fault in _stuck(campaign, k, sd, step)]
    return sorted(found, key=lambda fault: campaign.gauges.index(fault.gauge))


def _stuck(campaign: Campaign, gauge: int, sd: float, step_of_all: float) -> list[Fault]:
    values = campaign.readings[:, gauge]
    recorded = np.flatnonzero(np.isfinite(values))
    every = _runs(values, recorded) if recorded.size else []
    if not every:
        return []
    step = quantisation_step(values[:, None]) or step_of_all
    chance = max(float(erf(step * QUIET / (2.0 * np.sqrt(2.0) * sd))), 1e-3)
    runs = [run for run in every if recorded.size * chance ** (len(run) - 1) < CHANCE]
    is_whole = bool(runs) and sum(len(run) for run in runs) == recorded.size
    kept = runs if is_whole else [run for run in runs if _is_still(campaign, values, run)]
    if not kept:
        return []
    rows, name = np.concatenate(kept), campaign.gauges[gauge]
    levels, first = np.unique(values[rows]), int(rows[0])
    at = f"at {levels[0]:g} {campaign.unit_of(name)}" if len(levels) == 1 else f"at {len(levels)} levels"
    if is_whole:
        words = f"Stuck: readings of {name} never change between repeats ({at}); the channel is left out. Repair it."
    else:
        which = f"{len(rows)} readings (first in row {campaign.row_number(first)})"
        words = f"Stuck: channel {name} stands still {at} in {which}; they are left out. Repair it."
    return [Fault("stuck", name, rows, words, float(levels[0]), first)]


def _runs(values: NDArray[np.float64], recorded: NDArray[np.int64]) -> list[NDArray[np.int64]]:
    """Return the rows of every run of equal readings, in the order of recording."""
    ends = np.array([0, *(np.flatnonzero(np.diff(values[recorded]) != 0.0) + 1), len(recorded)])
    long = np.flatnonzero(np.diff(ends) >= LEAST_OF_A_CELL)
    return [recorded[ends[k] : ends[k + 1]] for k in long.tolist()]


def _is_still(campaign: Campaign, values: NDArray[np.float64], run: NDArray[np.int64]) -> bool:
    """Return whether a run is long, or a whole cell, and no end of the range that the load has reached."""
    cells = [cell for cell in campaign.cells if np.isin(cell.rows, run).any()]
    is_cell = any((np.isin(cell.rows, run) | np.isnan(values[cell.rows])).all() for cell in cells)
    return (len(run) >= LEAST_EQUAL or is_cell) and not _is_rail(campaign, values, run, cells)


def _is_rail(campaign: Campaign, values: NDArray[np.float64], run: NDArray[np.int64], cells: Sequence[Cell]) -> bool:
    """Return whether a run is the end of the range, which only the greatest loads reach: that is clipped, not stuck.

    Noise takes a clipped reading to the end of the range again and again; a channel that sticks within a cell was never
    there before.
    """
    level = float(values[run[0]])
    for cell in cells:
        outside = values[np.setdiff1d(cell.rows, run)]
        if np.isfinite(outside).sum() >= LEAST_OF_A_CELL and not (outside == level).any():
            return False
    low, high = float(np.nanmin(values)), float(np.nanmax(values))
    if level not in (low, high) or low == high:
        return False
    here = {id(cell) for cell in cells}
    free = [_size(cell.load) for cell in campaign.cells if id(cell) not in here]
    return bool(free) and min(_size(cell.load) for cell in cells) > max(free)


def _size(load: Load) -> float:
    return float(np.linalg.norm(amounts_of(load)))


def clipped_in(campaign: Campaign) -> list[Fault]:
    """Return the ends of the range that gauges met, the upper one of each first."""
    found = []
    for k, name in enumerate(campaign.gauges):
        for rail in _rails(campaign, k):
            at_rail = campaign.readings[:, k] == rail
            cells = [cell for cell in campaign.cells if at_rail[cell.rows].any()]
            first = int(np.flatnonzero(at_rail)[0])
            words = (
                f"Clipped: column {name} stops at {rail:g} {campaign.unit_of(name)} in {int(at_rail.sum())} readings "
                f"(first in row {campaign.row_number(first)}); it is left out of "
                f"{', '.join(cell.name for cell in cells)}. Widen the channel's range."
            )
            found.append(Fault("clipped", name, np.concatenate([cell.rows for cell in cells]), words, rail, first))
    return found


def _rails(campaign: Campaign, gauge: int) -> list[float]:
    """Return the readings at which a gauge stops; none of one that never moves: that is stuck."""
    values = campaign.readings[:, gauge]
    levels, counts = np.unique(values[np.isfinite(values)], return_counts=True)
    if len(levels) < 2:
        return []
    ends = [(float(levels[end]), counts[end], counts[inner]) for end, inner in ((-1, -2), (0, 1))]
    rails = [rail for rail, count, beside in ends if count >= FEWEST_AT_RAIL and count > 2 * beside]
    return rails if rails and _is_fine(campaign, gauge, levels, rails) else []


def _is_fine(campaign: Campaign, gauge: int, levels: NDArray[np.float64], rails: list[float]) -> bool:
    """Return whether the resolution is finer than the noise away from the rails: coarse steps repeat any reading."""
    cells = enumerate(campaign.cells)
    free = [k for k, c in cells if c.count[gauge] > 2 and not np.isin(campaign.readings[c.rows, gauge], rails).any()]
    return bool(free) and float(np.diff(levels).min()) < float(np.median(campaign.spreads()[free, gauge]))


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
