"""The check of the readings before anything else: what single channels do wrong is named and left out.

| fault | what becomes of it |
|---|---|
| stuck | readings that stand still are left out, the channel where it recorded nothing else |
| clipped | readings of the cells that met the end of the range are left out |
| jump | readings of its cell are left out, later ones have an unknown offset |
| outliers | means withstand them |

The noise is then that of the repeats, of the commissioning run, or what is known of the instrument.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from octmip.errors import DataError
from octmip.gap.campaign.campaign import Campaign, Fault
from octmip.gap.campaign.noise import Noise, given_noise
from octmip.gap.campaign.noise_estimate import estimate_noise
from octmip.gap.channels.faults import clipped_in, jumps_in, stuck_in
from octmip.gap.channels.outliers import robust

KINDS = (stuck_in, clipped_in, jumps_in)
"""What is looked for, each in what the one before has left."""
FINDINGS = {"stuck": "stuck_channel", "clipped": "clipping", "jump": "jump"}
"""Name of the finding that a kind of fault is, of the effects' list."""
NAMED = 4
"""Channels named one by one in a sentence about many."""


@dataclass(frozen=True, slots=True, eq=False)
class Checked:
    """A campaign without what its channels do wrong.

    Attributes
    ----------
    campaign
        what is left.
    faults
        what is left out.
    outliers
        by gauge with far-off readings, their share.
    is_one_sided
        whether far-off readings lie to one side.
    """

    campaign: Campaign
    faults: tuple[Fault, ...]
    outliers: Mapping[str, float]
    is_one_sided: bool

    @property
    def notes(self) -> tuple[str, ...]:
        """A sentence for each fault, what stands still first, and one on far-off readings."""
        words = [fault.words for fault in self.faults]
        most = sorted(self.outliers.items(), key=lambda pair: -pair[1])
        if most:
            named = ", ".join(f"{name} {100 * part:.1f} %" for name, part in most[:NAMED])
            rest = f" and {len(most) - NAMED} more" if len(most) > NAMED else ""
            end = "of all; means are taken so that they do not count. Look for interference."
            words.append(f"Far-off readings: {named}{rest} {end}")
        return tuple(words)

    @property
    def findings(self) -> tuple[str, ...]:
        """Names of what was found."""
        kinds = {fault.kind for fault in self.faults}
        found = [name for kind, name in FINDINGS.items() if kind in kinds]
        far = "outliers" if self.is_one_sided else "heavy_tailed_noise"
        return (*found, *[far] * bool(self.outliers))


def checked(campaign: Campaign) -> Checked:
    """Return the campaign without what its channels do wrong; channels of which nothing is left are no longer in it.

    Raises
    ------
    DataError
        nothing is left.
    """
    left, faults = campaign, []
    for look in KINDS:
        found = look(left)
        left = _without(left, found)
        faults += found
    sturdy = robust(left)
    left = _without_silent(replace(left, readings=sturdy.readings), campaign)
    return Checked(left, tuple(faults), sturdy.share, sturdy.is_one_sided)


def calm(run: Campaign) -> Campaign:
    """Return a commissioning run without what its channels do wrong, its gauges all kept.

    It began with gauges at zero, so what a gauge shows after a jump is left out.
    """
    found = checked(run)
    readings = np.full_like(run.readings, np.nan)
    readings[:, [run.gauges.index(name) for name in found.campaign.gauges]] = found.campaign.readings
    for jump in (fault for fault in found.faults if fault.kind == "jump"):
        readings[jump.first :, run.gauges.index(jump.gauge)] = np.nan
    return replace(run, readings=readings) if np.isfinite(readings).any() else run


def _without(campaign: Campaign, faults: Sequence[Fault]) -> Campaign:
    if not faults:
        return campaign
    readings = np.array(campaign.readings)
    for fault in faults:
        readings[fault.rows, campaign.gauges.index(fault.gauge)] = np.nan
    if not np.isfinite(readings).any():
        raise DataError(
            f"of {len(campaign.gauges)} gauges no reading is left ({faults[0].words}); expected readings that scatter; "
            "look whether the table holds copies of one row"
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


def noise_of(
    checks: Checked, run: Campaign | None, noise_sd: float | Mapping[str, float] | None
) -> tuple[Noise, list[str]]:
    """Return the noise with what the channels do wrong, and notes on where it is from."""
    noise, notes = _from_repeats_or_known(checks.campaign, run, noise_sd)
    known = {fault.gauge for fault in checks.faults if fault.kind == "stuck"}
    quiet = [fault for fault in noise.faults if fault.gauge not in known]
    properties = tuple(dict.fromkeys((*noise.properties, *checks.findings)))
    noise = replace(noise, faults=(*checks.faults, *quiet), properties=properties)
    return noise, [*notes, *(fault.words for fault in quiet)]


def _from_repeats_or_known(
    campaign: Campaign, run: Campaign | None, noise_sd: float | Mapping[str, float] | None
) -> tuple[Noise, list[str]]:
    """Return the noise and where it is from: the repeats, else the commissioning run's, else what is given."""
    given = None if noise_sd is None else given_noise(campaign.gauges, noise_sd)
    if campaign.has_repeats:
        unused = "The noise is estimated from the repeats; the given standard deviation is not used."
        return estimate_noise(campaign, run), [] if given is None else [unused]
    few = "Every test holds too few repeats to estimate the noise; "
    if given is not None:
        return given, [few + "the given standard deviation is taken as known."]
    return estimate_noise(campaign, run).of_gauges(campaign.gauges), [few + "the commissioning run's noise is used."]


def noise_of_run(run: Campaign, known: Noise) -> tuple[Noise, list[str]]:
    """Return the noise of a commissioning run for the campaign's gauges; its noise stands in for too few repeats.

    Raises
    ------
    DataError
        the run lacks a gauge of the campaign.
    """
    missing = [name for name in known.gauges if name not in run.gauges]
    if missing:
        raise DataError(f"the commissioning run lacks gauge {missing[0]}; expected every gauge of the campaign")
    if run.has_repeats:
        return estimate_noise(run).of_gauges(known.gauges), []
    note = "The commissioning run holds too few repeats to estimate its noise; the campaign's is used."
    return replace(known, faults=()), [note]
