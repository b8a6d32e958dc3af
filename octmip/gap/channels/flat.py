"""The same number again and again where noise would change it: stuck channels, and ends of the range.

A reading falls into the most probable step of its converter with probability p = erf(step / (2 sqrt(2) sd)); a run of m
equal readings by chance has a probability of at most n p^(m-1), n the number of readings. Runs less probable than
`CHANCE` are readings of a channel that stands still, always or for a time. Coarse steps repeat any reading: p is near
1, and no run is long enough.

Continuous noise seldom repeats its extreme reading. A gauge whose greatest (or least) reading stands in the table at
least `FEWEST_AT_RAIL` times, and more than twice as often as the next one, has met the end of its range. The mean of
such a cell is biased toward the inside by an amount that depends on what lies beyond, so that gauge's readings of that
cell are left out.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.special import erf

from octmip.gap.campaign.campaign import Campaign, Cell
from octmip.gap.campaign.fault import Fault
from octmip.gap.campaign.noise_estimate import least_variance, quantisation_step
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
    runs = np.split(recorded, np.flatnonzero(np.diff(values[recorded]) != 0.0) + 1)
    return [run for run in runs if len(run) >= LEAST_OF_A_CELL]


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
