"""Clipped gauges: an amplifier or a converter at the end of its range writes the same number again and again.

Continuous noise seldom repeats its extreme reading. A gauge whose greatest (or least) reading stands in the table at
least FEWEST times, and more than twice as often as the next one, has met a rail. The mean of such a test is biased
toward the inside by an amount that depends on what lies beyond the rail, so that gauge's readings of that test and load
are taken out: what is left is unbiased, and every other effect is diagnosed as if the gauge had been missing there.
"""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from octmip.gap.campaign.campaign import Campaign

FEWEST = 4
"""Equal extreme readings that make a rail."""


def unclipped(campaign: Campaign) -> tuple[Campaign, dict[str, float], list[str]]:
    """Return the campaign without the clipped readings, the rail of each clipped gauge in its unit, and notes.

    Of a gauge that meets both ends of its range the upper one is told; the notes have both.
    """
    readings = np.array(campaign.readings)
    rails: dict[str, float] = {}
    notes = []
    for k, name in enumerate(campaign.gauges):
        for rail in rails_of(campaign, k):
            at_rail = campaign.readings[:, k] == rail
            cells = [cell for cell in campaign.cells if at_rail[cell.rows].any()]
            for cell in cells:
                readings[cell.rows, k] = np.nan
            rails.setdefault(name, rail)
            first = campaign.row_number(int(np.flatnonzero(at_rail)[0]))
            notes.append(
                f"Clipped: column {name} stops at {rail:g} {campaign.unit_of(name)} in {int(at_rail.sum())} readings "
                f"(first in row {first}); it is left out of {', '.join(cell.name for cell in cells)}. Widen the "
                "channel's range."
            )
    if not rails or not np.isfinite(readings).any():
        return campaign, {}, []
    return replace(campaign, readings=readings), rails, notes


def rails_of(campaign: Campaign, gauge: int) -> list[float]:
    """Return the readings at which a gauge stops, the upper end first; none of one that never moves: that is stuck."""
    values = campaign.readings[:, gauge]
    levels, counts = np.unique(values[np.isfinite(values)], return_counts=True)
    if len(levels) < 2:
        return []
    ends = [(float(levels[end]), counts[end], counts[inner]) for end, inner in ((-1, -2), (0, 1))]
    rails = [rail for rail, count, next_to_it in ends if count >= FEWEST and count > 2 * next_to_it]
    return [rail for rail in rails if _is_fine(campaign, gauge, levels, rails)]


def _is_fine(campaign: Campaign, gauge: int, levels: NDArray[np.float64], rails: list[float]) -> bool:
    """Return whether the resolution is finer than the noise away from the rails: coarse steps repeat any reading."""
    spreads = []
    for cell in campaign.cells:
        values = campaign.readings[cell.rows, gauge]
        values = values[np.isfinite(values)]
        if len(values) >= 3 and not np.isin(values, rails).any():
            spreads.append(float(values.std(ddof=1)))
    return bool(spreads) and float(np.diff(levels).min()) < float(np.median(spreads))
