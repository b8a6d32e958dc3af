"""Stuck channels: the same number again and again where noise would change it.

A reading falls into the most probable step of its converter with probability p = erf(step / (2 sqrt(2) sd)); a run of m
equal readings by chance has a probability of at most n p^(m-1), n the number of readings. Runs less probable than
`CHANCE` are readings of a channel that stands still, always or for a time. Coarse steps repeat any reading: p is near
1, and no run is long enough.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.special import erf

from octmip.gap.campaign.campaign import Campaign, Cell
from octmip.gap.campaign.noise_estimate import quantisation_step

CHANCE = 1e-6
"""Probability below which equal readings are no chance."""
LEAST_EQUAL = 8
"""Equal readings that make a run, where it is not a whole cell: slow channels hold a reading for a few rows."""
LEAST_OF_A_CELL = 4
"""Equal readings that make a run where they are a whole cell."""
QUIET = 3.0
"""Factor by which one channel may be quieter than the typical one."""


@dataclass(frozen=True, slots=True, eq=False)
class Stuck:
    """Readings of one channel that stands still.

    Attributes
    ----------
    gauge
        index of the channel.
    rows
        (n,) rows of the campaign.
    is_whole
        whether the channel recorded nothing else.
    """

    gauge: int
    rows: NDArray[np.int64]
    is_whole: bool


def stuck_in(campaign: Campaign) -> list[Stuck]:
    """Return what stands still, one entry per channel."""
    sd = _typical_sd(campaign)
    if sd == 0.0:
        return []
    step_of_all = quantisation_step(campaign.readings)
    found = []
    for k in range(len(campaign.gauges)):
        values = campaign.readings[:, k]
        recorded = np.flatnonzero(np.isfinite(values))
        if not recorded.size:
            continue
        step = quantisation_step(values[:, None]) or step_of_all
        chance = max(float(erf(step * QUIET / (2.0 * np.sqrt(2.0) * sd))), 1e-3)
        runs = [run for run in _runs(values, recorded) if recorded.size * chance ** (len(run) - 1) < CHANCE]
        rows = [run for run in runs if _is_still(campaign, values, run)]
        if rows:
            joined = np.concatenate(rows)
            found.append(Stuck(k, joined, len(joined) == recorded.size))
    return found


def _typical_sd(campaign: Campaign) -> float:
    """Return the median over the gauges that scatter of the standard deviation within cells, 0 where none does."""
    spreads = [np.nanvar(campaign.readings[cell.rows][:, cell.count > 1], axis=0, ddof=1) for cell in campaign.cells]
    every = np.concatenate(spreads) if spreads else np.zeros(0)
    every = every[every > 1e-18]
    return float(np.sqrt(np.median(every))) if every.size else 0.0


def _runs(values: NDArray[np.float64], recorded: NDArray[np.int64]) -> list[NDArray[np.int64]]:
    """Return the rows of every run of equal readings, in the order of recording."""
    breaks = np.flatnonzero(np.diff(values[recorded]) != 0.0) + 1
    return [run for run in np.split(recorded, breaks) if len(run) >= LEAST_OF_A_CELL]


def _is_still(campaign: Campaign, values: NDArray[np.float64], run: NDArray[np.int64]) -> bool:
    """Return whether a run is long, or a whole cell, and no end of the range that the load has reached."""
    inside = set(run.tolist())
    cells = [cell for cell in campaign.cells if inside & set(cell.rows.tolist())]
    of_cell = [cell.rows[np.isfinite(values[cell.rows])] for cell in cells]
    is_cell = any(set(rows.tolist()) <= inside for rows in of_cell)
    if len(run) < LEAST_EQUAL and not is_cell:
        return False
    return not _is_rail(campaign, values, float(values[run[0]]), cells)


def _is_rail(campaign: Campaign, values: NDArray[np.float64], level: float, cells: Sequence[Cell]) -> bool:
    """Return whether the level is an extreme reading that only the greatest loads have: that is clipped, not stuck."""
    finite = values[np.isfinite(values)]
    if level not in (float(finite.min()), float(finite.max())) or float(finite.min()) == float(finite.max()):
        return False
    here = {id(cell) for cell in cells}
    free = [abs(cell.load_factor) for cell in campaign.cells if id(cell) not in here]
    return bool(free) and min(abs(cell.load_factor) for cell in cells) > max(free)
