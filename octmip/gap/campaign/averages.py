"""Averages of repeats: the cells of a campaign, or halves of them where an effect depends on time."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from octmip.gap.campaign.campaign import Campaign

ENOUGH_FOR_HALVES = 16
"""Repeats from which a cell is averaged in two halves where time matters."""


@dataclass(frozen=True, slots=True, eq=False)
class AveragedCell:
    """Repeats that are averaged together: a cell of the campaign, or half of one where time matters.

    Attributes
    ----------
    cell
        index of the campaign's cell.
    mean, count
        (n_gauges,) of these repeats.
    time
        mean time [s].
    rows
        (n_repeats,) rows of the campaign.
    moments
        (n_repeats,) when they were read, in steps from one reading to the next, the campaign's first at 1.
    """

    cell: int
    mean: NDArray[np.float64]
    count: NDArray[np.int64]
    time: float
    rows: NDArray[np.int64]
    moments: NDArray[np.float64]

    def of_gauges(self, order: Sequence[int]) -> "AveragedCell":
        """Return the average of these gauges, in their order."""
        return replace(self, mean=self.mean[list(order)], count=self.count[list(order)])


def averages_of(campaign: Campaign, split: bool) -> tuple[AveragedCell, ...]:
    """Return whole cells, or the earlier and later half of each where `split` and time was recorded, averaged."""
    found = []
    moments = moments_of(campaign)
    start = float(np.nanmin(campaign.time)) if np.isfinite(campaign.time).any() else 0.0
    for k, cell in enumerate(campaign.cells):
        halves = [cell.rows]
        if split and campaign.has_time and len(cell.rows) >= ENOUGH_FOR_HALVES:
            rows = cell.rows[np.argsort(campaign.time[cell.rows], kind="stable")]
            halves = [rows[: len(rows) // 2], rows[len(rows) // 2 :]]
        for rows in halves:
            readings = campaign.readings[rows]
            count = np.isfinite(readings).sum(axis=0)
            mean = np.where(count > 0, np.nansum(readings, axis=0) / np.maximum(count, 1), np.nan)
            time = float(np.nanmean(campaign.time[rows])) - start if campaign.has_time else cell.time
            found.append(AveragedCell(k, mean, count, time, rows, moments[rows]))
    return tuple(found)


def moments_of(campaign: Campaign) -> NDArray[np.float64]:
    """Return when every row was read (n_rows,), in typical steps from one reading to the next, the first at 1.

    Rows count where no time was recorded: they are in the order of reading.
    """
    rows = np.arange(1.0, len(campaign.test) + 1.0)
    if not campaign.has_time:
        return rows
    steps = np.diff(np.sort(campaign.time))
    steps = steps[steps > 0.0]
    if not steps.size:
        return rows
    return np.asarray(1.0 + (campaign.time - campaign.time.min()) / float(np.median(steps)))
