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
    units = np.array([campaign.unit_of(name) for name in campaign.gauges])
    alike = [np.flatnonzero(units == unit) for unit in dict.fromkeys(units.tolist())]
    found = [entry for gauges in alike for entry in _stuck_of_unit(campaign, gauges)]
    return sorted(found, key=lambda entry: entry.gauge)


def _stuck_of_unit(campaign: Campaign, gauges: NDArray[np.int64]) -> list[Stuck]:
    """Return what stands still of the channels of one unit."""
    sd = _typical_sd(campaign, gauges)
    if sd == 0.0:
        return []
    found, step_of_all = [], None
    for k in gauges.tolist():
        values = campaign.readings[:, k]
        recorded = np.flatnonzero(np.isfinite(values))
        every = _runs(values, recorded) if recorded.size else []
        if not every:
            continue
        if step_of_all is None:
            step_of_all = quantisation_step(campaign.readings[:, gauges])
        step = quantisation_step(values[:, None]) or step_of_all
        chance = max(float(erf(step * QUIET / (2.0 * np.sqrt(2.0) * sd))), 1e-3)
        runs = [run for run in every if recorded.size * chance ** (len(run) - 1) < CHANCE]
        is_whole = bool(runs) and sum(len(run) for run in runs) == recorded.size
        rows = runs if is_whole else [run for run in runs if _is_still(campaign, values, run)]
        if rows:
            found.append(Stuck(k, np.concatenate(rows), is_whole))
    return found


def _typical_sd(campaign: Campaign, gauges: NDArray[np.int64]) -> float:
    """Return the median over the gauges that scatter of the standard deviation within cells, 0 where none does."""
    seen = [gauges[cell.count[gauges] > 1] for cell in campaign.cells]
    pairs = zip(campaign.cells, seen, strict=True)
    spreads = [np.nanvar(campaign.readings[np.ix_(cell.rows, some)], axis=0, ddof=1) for cell, some in pairs]
    every = np.concatenate(spreads) if spreads else np.zeros(0)
    every = every[every > least_variance(campaign.readings[:, gauges]).max()]
    return float(np.sqrt(np.median(every))) if every.size else 0.0


def _runs(values: NDArray[np.float64], recorded: NDArray[np.int64]) -> list[NDArray[np.int64]]:
    """Return the rows of every run of equal readings, in the order of recording."""
    starts = np.concatenate([[0], np.flatnonzero(np.diff(values[recorded]) != 0.0) + 1])
    ends = np.append(starts[1:], len(recorded))
    long = np.flatnonzero(ends - starts >= LEAST_OF_A_CELL)
    return [recorded[starts[k] : ends[k]] for k in long]


def _is_still(campaign: Campaign, values: NDArray[np.float64], run: NDArray[np.int64]) -> bool:
    """Return whether a run is long, or a whole cell, and no end of the range that the load has reached."""
    inside = set(run.tolist())
    cells = [cell for cell in campaign.cells if inside & set(cell.rows.tolist())]
    of_cell = [cell.rows[np.isfinite(values[cell.rows])] for cell in cells]
    is_cell = any(set(rows.tolist()) <= inside for rows in of_cell)
    if len(run) < LEAST_EQUAL and not is_cell:
        return False
    return not _is_rail(campaign, values, run, cells)


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
    finite = values[np.isfinite(values)]
    if level not in (float(finite.min()), float(finite.max())) or float(finite.min()) == float(finite.max()):
        return False
    here = {id(cell) for cell in cells}
    free = [_size(cell.load) for cell in campaign.cells if id(cell) not in here]
    return bool(free) and min(_size(cell.load) for cell in cells) > max(free)


def _size(load: Load) -> float:
    return float(np.linalg.norm(amounts_of(load)))
