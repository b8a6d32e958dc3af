"""The check of the readings before anything else: what single channels do wrong is named and left out.

| fault | what becomes of it |
|---|---|
| clipped | readings of the cells that met the end of the range are left out |
| stuck | readings that stand still are left out, the channel where it recorded nothing else |
| jump | readings of its cell are left out, later ones have an unknown offset |
| outliers | means withstand them |
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from octmip.errors import DataError
from octmip.gap.campaign.campaign import Campaign
from octmip.gap.campaign.clipping import unclipped
from octmip.gap.campaign.noise import Jump
from octmip.gap.channels.jumps import Found, jumps_in
from octmip.gap.channels.outliers import robust
from octmip.gap.channels.stuck import Stuck, stuck_in

NAMED = 4
"""Channels named one by one in a sentence about many."""


@dataclass(frozen=True, slots=True, eq=False)
class Checked:
    """A campaign without what its channels do wrong.

    Attributes
    ----------
    campaign
        what is left.
    stuck
        channels that stand still, always or for a time.
    clipped
        by channel that met the end of its range, where that lies in its unit.
    jumps
        gauges that jumped.
    outliers
        by gauge with far-off readings, their share.
    is_one_sided
        whether far-off readings lie to one side.
    notes
        a sentence for each, what stands still first.
    """

    campaign: Campaign
    stuck: tuple[str, ...]
    clipped: Mapping[str, float]
    jumps: tuple[Jump, ...]
    outliers: Mapping[str, float]
    is_one_sided: bool
    notes: tuple[str, ...]

    @property
    def findings(self) -> tuple[str, ...]:
        """Names of what was found."""
        found = {
            "stuck_channel": bool(self.stuck),
            "clipping": bool(self.clipped),
            "jump": bool(self.jumps),
            "outliers": self.is_one_sided,
            "heavy_tailed_noise": bool(self.outliers) and not self.is_one_sided,
        }
        return tuple(name for name, is_there in found.items() if is_there)


def checked(campaign: Campaign) -> Checked:
    """Return the campaign without what its channels do wrong; channels of which nothing is left are no longer in it.

    Raises
    ------
    DataError
        nothing is left.
    """
    still = stuck_in(campaign)
    left, rails, of_clipping = unclipped(_without_readings(campaign, still))
    jumped = jumps_in(left)
    left = _without_jumps(left, jumped)
    sturdy = robust(left)
    left = _without_silent(replace(left, readings=sturdy.readings), campaign)
    jumps = tuple(Jump(campaign.gauges[j.gauge], j.row, j.size) for j in jumped)
    notes = (
        *(_of_stuck(campaign, entry) for entry in still),
        *of_clipping,
        *(_of_jump(campaign, jump) for jump in jumped),
        *_of_outliers(sturdy.share),
    )
    names = tuple(campaign.gauges[entry.gauge] for entry in still)
    return Checked(left, names, rails, jumps, sturdy.share, sturdy.is_one_sided, notes)


def calm(run: Campaign) -> Campaign:
    """Return a commissioning run without what its channels do wrong, its gauges all kept.

    It began with gauges at zero, so what a gauge shows after a jump is left out.
    """
    found = checked(run)
    readings = np.full_like(run.readings, np.nan)
    readings[:, [run.gauges.index(name) for name in found.campaign.gauges]] = found.campaign.readings
    for jump in found.jumps:
        readings[jump.row :, run.gauges.index(jump.gauge)] = np.nan
    return replace(run, readings=readings) if np.isfinite(readings).any() else run


def _without_readings(campaign: Campaign, still: list[Stuck]) -> Campaign:
    if not still:
        return campaign
    readings = np.array(campaign.readings)
    for entry in still:
        readings[entry.rows, entry.gauge] = np.nan
    if not np.isfinite(readings).any():
        raise DataError(
            f"all {len(campaign.gauges)} gauges stand still (first {campaign.gauges[0]}); expected readings that "
            "scatter; look whether the table holds copies of one row"
        )
    return replace(campaign, readings=readings)


def _without_silent(campaign: Campaign, before: Campaign) -> Campaign:
    """Return the campaign without the gauges that recorded something before and of which nothing is left."""
    silent = np.isfinite(before.readings).any(axis=0) & ~np.isfinite(campaign.readings).any(axis=0)
    keep = np.flatnonzero(~silent)
    if len(keep) == len(campaign.gauges):
        return campaign
    gauges = tuple(campaign.gauges[k] for k in keep)
    units = tuple(campaign.units[k] for k in keep) if campaign.units else ()
    return replace(campaign, gauges=gauges, readings=campaign.readings[:, keep], units=units)


def _without_jumps(campaign: Campaign, jumps: list[Found]) -> Campaign:
    if not jumps:
        return campaign
    readings: NDArray[np.float64] = np.array(campaign.readings)
    for jump in jumps:
        readings[campaign.cells[jump.cell].rows, jump.gauge] = np.nan
    return replace(campaign, readings=readings)


def _of_stuck(campaign: Campaign, entry: Stuck) -> str:
    name, first = campaign.gauges[entry.gauge], int(entry.rows[0])
    levels = np.unique(campaign.readings[entry.rows, entry.gauge])
    at = f"at {levels[0]:g} {campaign.unit_of(name)}" if len(levels) == 1 else f"at {len(levels)} levels"
    if entry.is_whole:
        return f"Stuck: readings of {name} never change between repeats ({at}); the channel is left out. Repair it."
    rows = f"{len(entry.rows)} readings (first in row {campaign.row_number(first)})"
    return f"Stuck: channel {name} stands still {at} in {rows}; they are left out. Repair it."


def _of_jump(campaign: Campaign, jump: Found) -> str:
    name, cell = campaign.gauges[jump.gauge], campaign.cells[jump.cell].name
    size = f"{jump.size:+.3g} {campaign.unit_of(name)}"
    return (
        f"Jump: gauge {name} moves by {size} at row {campaign.row_number(jump.row)} ({cell}); its readings there are "
        "left out, and later ones have an unknown offset. Look at its wiring."
    )


def _of_outliers(share: Mapping[str, float]) -> list[str]:
    if not share:
        return []
    most = sorted(share.items(), key=lambda pair: -pair[1])
    named = ", ".join(f"{name} {100 * part:.1f} %" for name, part in most[:NAMED])
    rest = f" and {len(most) - NAMED} more" if len(most) > NAMED else ""
    return [
        f"Far-off readings: {named}{rest} of all; means are taken so that they do not count. Look for interference."
    ]
