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
    """Return the campaign without the clipped readings, the rail of each clipped gauge in its unit, and notes."""
    readings = np.array(campaign.readings)
    rails: dict[str, float] = {}
    notes = []
    for k, name in enumerate(campaign.gauges):
        rail = rail_of(campaign, k)
        if rail is None:
            continue
        at_rail = campaign.readings[:, k] == rail
        cells = [cell for cell in campaign.cells if at_rail[cell.rows].any()]
        for cell in cells:
            readings[cell.rows, k] = np.nan
        rails[name] = rail
        first = campaign.row_number(int(np.flatnonzero(at_rail)[0]))
        notes.append(
            f"Clipped: column {name} stops at {rail:g} {campaign.unit_of(name)} in {int(at_rail.sum())} readings "
            f"(first in row {first}); it is left out of {', '.join(cell.name for cell in cells)}. Widen the channel's "
            "range."
        )
    if not rails or not np.isfinite(readings).any():
        return campaign, {}, []
    return replace(campaign, readings=readings), rails, notes


def rail_of(campaign: Campaign, gauge: int) -> float | None:
    """Return the reading at which a gauge stops, or None; a gauge that never moves is stuck, not clipped."""
    values = campaign.readings[:, gauge]
    levels, counts = np.unique(values[np.isfinite(values)], return_counts=True)
    if len(levels) < 2:
        return None
    for end, inner in ((-1, -2), (0, 1)):
        rail = float(levels[end])
        repeated = counts[end] >= FEWEST and counts[end] > 2 * counts[inner]
        if repeated and _is_fine(campaign, gauge, levels, rail):
            return rail
    return None


def _is_fine(campaign: Campaign, gauge: int, levels: NDArray[np.float64], rail: float) -> bool:
    """Return whether the resolution is finer than the noise away from the rail: coarse steps repeat any reading."""
    spreads = []
    for cell in campaign.cells:
        values = campaign.readings[cell.rows, gauge]
        values = values[np.isfinite(values)]
        if len(values) >= 3 and not (values == rail).any():
            spreads.append(float(values.std(ddof=1)))
    return bool(spreads) and float(np.diff(levels).min()) < float(np.median(spreads))
