"""Equal readings, and what they mean beside the twin: a stuck channel, an end of the range, or one reading held.

| equal readings | what they are | what becomes of them |
|---|---|---|
| at loads between which the twin moves by `FOLLOWS` steps or standard deviations | a stuck channel | left out |
| of a whole cell or a long run, off the line of the gauge's other readings | a stuck channel | left out |
| the extreme ones, piled up where the twin lies beyond them | an end of the range | their cells are left out |
| of a cell, where the noise would change them | one reading, held or tared | count once |
| all others | a display with coarse steps | stay (`octmip.gap.campaign.display`) |

So a channel is accused only where its readings do not follow the load as the twin says that they must. A tared zero,
a dial that returns to its mark and a logger that repeats a sample follow it. The twin need not be right: what it says
is multiplied by the factor that the gauge's free readings show.

A reading falls into the most probable step of its display with probability p = erf(step / (2 sqrt(2) sd)), so m equal
ones are a chance of p^(m-1); among n readings at most n times that.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.special import erf
from scipy.stats import binom, norm

from octmip.gap.campaign.campaign import Campaign, Cell, Fault
from octmip.gap.campaign.display import steps_of

Floats = NDArray[np.float64]
Rows = NDArray[np.int64]

FOLLOWS = 4.0
"""Steps, or standard deviations, by which the twin moves at least where a reading must change."""
OFF = 5.0
"""The same by which a reading lies off the line of the others that does not follow the load."""
BEYOND, SHARE_BEYOND = 3.0, 0.05
"""The same, or the share of the reading, by which the twin lies beyond a range at whose end a whole cell stands."""
AS_OFTEN = 0.01
"""Probability that noise takes so many readings of a cell to the end of the range, below which they are stuck there."""
PILED = 1e-4
"""Probability that so many readings of a cell fall into the most probable step, below which they pile up."""
CHANCE, HELD = 1e-6, 0.05
"""Probability below which equal readings of a campaign, and of one cell, are no chance."""
LEAST_EQUAL, LEAST_OF_A_CELL = 8, 4
"""Equal readings that make a run: slow channels hold a reading for a few rows; and where they are a whole cell."""
QUIET = 3.0
"""Factor by which one channel may be quieter than the typical one."""
LEAST_CHANCE = 1e-3
"""Probability that two readings of the finest display are equal."""


@dataclass(frozen=True, slots=True, eq=False)
class _Channel:
    """One gauge beside its twin.

    Attributes
    ----------
    campaign, gauge
        whose readings they are, and its number.
    values, predicted
        (n_rows,) readings, and what the twin says.
    step, sd
        of its display, and of its noise; 0 where not known.
    is_own
        whether the noise is its own, not the typical of its unit.
    """

    campaign: Campaign
    gauge: int
    values: Floats
    predicted: Floats
    step: float
    sd: float
    is_own: bool

    @property
    def least(self) -> float:
        """What tells two readings apart."""
        return max(self.step, self.sd)

    @property
    def chance(self) -> float:
        """Probability that two readings of one value are equal."""
        sd = self.sd if self.is_own else self.sd / QUIET
        return max(float(erf(self.step / (2.0 * np.sqrt(2.0) * sd))), LEAST_CHANCE) if sd > 0.0 else 1.0

    @property
    def cells(self) -> list[tuple[Cell, Rows]]:
        """Every cell that it was read in, and its rows there."""
        own = [(cell, cell.rows[np.isfinite(self.values[cell.rows])]) for cell in self.campaign.cells]
        return [(cell, rows) for cell, rows in own if rows.size]

    def fault(self, kind: str, rows: Rows, level: float, words: str) -> Fault:
        """Return a fault of this channel."""
        return Fault(kind, self.campaign.gauges[self.gauge], rows, words, level, int(rows[0]))


def _channels(campaign: Campaign, predicted: Floats) -> list[_Channel]:
    units = np.array([campaign.unit_of(name) for name in campaign.gauges])
    steps, spreads = steps_of(campaign), campaign.spreads()
    found = []
    for k, unit in enumerate(units.tolist()):
        own, every = (part[part > 0.0] for part in (spreads[:, k], spreads[:, units == unit]))
        sd = next((float(np.median(part)) for part in (own, every) if part.size), 0.0)
        values = campaign.readings[:, k], predicted[:, k]
        found.append(_Channel(campaign, k, *values, float(steps[k]), sd, is_own=bool(own.size)))
    return found


def stuck_in(campaign: Campaign, predicted: Floats) -> list[Fault]:
    """Return what stands still where the twin (n_rows, n_gauges) says that it must move, one fault per channel."""
    return [fault for channel in _channels(campaign, predicted) for fault in _stuck(channel)]


def _stuck(channel: _Channel) -> list[Fault]:
    kept = [run for run, is_rail in _still(channel) if not is_rail]
    if not kept:
        return []
    rows, campaign = np.concatenate(kept), channel.campaign
    name, levels = campaign.gauges[channel.gauge], np.unique(channel.values[rows])
    at = f"at {levels[0]:g} {campaign.unit_of(name)}" if len(levels) == 1 else f"at {len(levels)} levels"
    if len(rows) == int(np.isfinite(channel.values).sum()):
        words = f"Stuck: readings of {name} never change ({at}); the channel is left out. Repair it."
    else:
        which = f"{len(rows)} readings (first in row {campaign.row_number(int(rows[0]))})"
        words = f"Stuck: channel {name} stands still {at} in {which}; they are left out. Repair it."
    return [channel.fault("stuck", rows, float(levels[0]), words)]


def _runs(values: Floats) -> list[Rows]:
    """Return the rows of every run of equal readings (n_rows,), in the order of recording."""
    recorded = np.flatnonzero(np.isfinite(values))
    ends = np.array([0, *(np.flatnonzero(np.diff(values[recorded]) != 0.0) + 1), len(recorded)])
    long = np.flatnonzero(np.diff(ends) >= LEAST_OF_A_CELL)
    return [recorded[ends[k] : ends[k + 1]] for k in long.tolist()]


def _still(channel: _Channel) -> list[tuple[Rows, bool]]:
    """Return the runs that do not follow the load, and whether each stands at the end of the range."""
    runs = _runs(channel.values)
    still = [run for run in runs if channel.sd > 0.0 and _is_still(channel, run, runs)]
    return [(run, _is_rail(channel, run)) for run in still]


def _is_still(channel: _Channel, run: Rows, runs: list[Rows]) -> bool:
    """Return whether a run does not follow the load: the twin moves within it, or it lies off all other readings."""
    if np.ptp(channel.predicted[run]) > FOLLOWS * channel.least:
        return True
    is_cell = any(np.isin(rows, run).all() for _, rows in channel.cells if np.isin(rows, run).any())
    count = int(np.isfinite(channel.values).sum())
    if (len(run) < LEAST_EQUAL and not is_cell) or count * channel.chance ** (len(run) - 1) >= CHANCE:
        return False
    others = np.setdiff1d(np.flatnonzero(np.isfinite(channel.values)), np.concatenate(runs))
    if not others.size or np.ptp(channel.predicted[others]) <= FOLLOWS * channel.least:
        return False
    slope, offset = np.polyfit(channel.predicted[others], channel.values[others], 1)
    level, expected = channel.values[run[0]], slope * channel.predicted[run[0]] + offset
    return bool(abs(level - expected) > OFF * channel.least)


def _is_rail(channel: _Channel, run: Rows) -> bool:
    """Return whether a still run is the end of the range that the load has reached: that is clipped, not stuck.

    Noise takes a reading to the end of the range as often as the twin is near to it; a channel that sticks stays.
    """
    level = float(channel.values[run[0]])
    sign = 1.0 if level == np.nanmax(channel.values) else -1.0
    if level not in (np.nanmin(channel.values), np.nanmax(channel.values)):
        return False
    is_met = False
    for rows, past in _past(channel, level, sign, 1.0):
        met = int((channel.values[rows] == level).sum())
        is_met |= met > 0 and past > 0.0
        if met and binom.sf(met - 1, len(rows), norm.cdf(past / channel.least)) < AS_OFTEN:
            return False
    return is_met


def clipped_in(campaign: Campaign, predicted: Floats) -> list[Fault]:
    """Return the ends of the range that gauges met, the upper one of each first."""
    found = []
    for channel in _channels(campaign, predicted):
        name = campaign.gauges[channel.gauge]
        ends = {float(channel.values[run[0]]) for run, is_rail in _still(channel) if is_rail}
        for rail in sorted({*_rails(channel), *ends}, reverse=True):
            first = np.flatnonzero(channel.values == rail)
            cells = [cell for cell, rows in channel.cells if (channel.values[rows] == rail).any()]
            words = (
                f"Clipped: column {name} stops at {rail:g} {campaign.unit_of(name)} in {len(first)} readings (first in "
                f"row {campaign.row_number(int(first[0]))}); it is left out of "
                f"{', '.join(cell.name for cell in cells)}. Widen the channel's range."
            )
            found.append(channel.fault("clipped", np.concatenate([cell.rows for cell in cells]), rail, words))
    return found


def _rails(channel: _Channel) -> list[float]:
    """Return the extreme readings that pile up where the twin, by the factor of free readings, lies beyond them."""
    levels, counts = np.unique(channel.values[np.isfinite(channel.values)], return_counts=True)
    if len(levels) < 2:
        return []
    found = []
    for end, inner, sign in ((-1, -2, 1.0), (0, 1, -1.0)):
        is_pile = counts[end] >= LEAST_OF_A_CELL and counts[end] > 2 * counts[inner]
        level = float(levels[end])
        past = _past(channel, level, sign, None) if is_pile else []
        if any(_is_beyond(channel, rows, level, distance) for rows, distance in past):
            found.append(level)
    return found


def _is_beyond(channel: _Channel, rows: Rows, level: float, past: float) -> bool:
    """Return whether readings of a cell stand at their extreme since the twin lies `past` it.

    Where all of them do, they may be one reading held: only a twin that is far beyond tells. Where noise takes some of
    them there the twin may lie a little inside, but not at 0: that is a display that shows nothing of small readings.
    """
    values = channel.values[rows]
    margin = max(BEYOND * channel.least, SHARE_BEYOND * float(np.abs(values).max()))
    if (values == values[0]).all():
        return past > margin
    is_loaded = abs(float(channel.predicted[rows[0]])) > channel.least
    equal = int((values == level).sum())
    return is_loaded and past > -margin and float(binom.sf(equal - 1, len(rows), channel.chance)) < PILED


def _past(channel: _Channel, level: float, sign: float, otherwise: float | None) -> list[tuple[Rows, float]]:
    """Return for every cell with readings at a level its rows and how far the twin lies beyond that.

    The twin is multiplied by the factor of the cells that are not at an end of the range, `otherwise` where the twin
    says 0 of these; nothing is known where there is none.
    """
    met = [(rows, bool((channel.values[rows] == level).any())) for _, rows in channel.cells]
    other = (np.nanmin if sign > 0.0 else np.nanmax)(channel.values)
    inside = [rows for rows, is_met in met if not is_met and (channel.values[rows] != other).mean() > 0.5]
    free = np.concatenate([np.zeros(0, dtype=np.int64), *inside])
    x, y = channel.predicted[free], channel.values[free]
    factor = float(x @ y) / float(x @ x) if x.any() else otherwise
    if factor is None or not free.size:
        return []
    return [(rows, sign * (factor * float(channel.predicted[rows[0]]) - level)) for rows, is_met in met if is_met]


def counted_once(campaign: Campaign) -> Campaign:
    """Return the campaign with readings that a channel held through a cell recorded once: they are one reading.

    A logger that repeats a sample repeats all of its channels, so where all stand still their chances multiply.
    """
    readings = np.array(campaign.readings)
    channels = _channels(campaign, np.zeros_like(readings))
    for cell in campaign.cells:
        held = [
            (channel, rows, channel.chance ** (len(rows) - 1))
            for channel in channels
            if len(rows := cell.rows[np.isfinite(channel.values[cell.rows])]) > 1
            and (channel.values[rows] == channel.values[rows[0]]).all()
        ]
        together = float(np.prod([chance for *_, chance in held])) if len(held) == len(channels) else 1.0
        for channel, rows, chance in held:
            if min(chance, together) < HELD:
                readings[rows[1:], channel.gauge] = np.nan
    return replace(campaign, readings=readings)
