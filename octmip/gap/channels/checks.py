"""The check of the readings before anything else: what single channels do wrong is named and left out.

| fault | what becomes of it |
|---|---|
| stuck | readings that stand still are left out, the channel where it recorded nothing else |
| clipped | readings of the cells that met the end of the range are left out |
| held | readings that repeat one another through a cell count once; no fault |
| jump | readings of its cell are left out, later ones have an unknown offset |
| far-off readings | are left out |

The noise is then that of the repeats, of the commissioning run, or what is known of the instrument.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from numpy.typing import NDArray

from octmip.errors import DataError
from octmip.gap.campaign.campaign import Campaign, Fault
from octmip.gap.campaign.noise import Noise, given_noise
from octmip.gap.campaign.noise_estimate import estimate_noise
from octmip.gap.channels.jumps import jumps_in
from octmip.gap.channels.levels import clipped_in, counted_once, stuck_in
from octmip.gap.channels.outliers import robust
from octmip.twin import Twin

Floats = NDArray[np.float64]

FINDINGS = {"stuck": "stuck_channel", "clipped": "clipping", "jump": "jump"}
"""Name of the finding that a kind of fault is, of the effects' list."""
HALF = 0.6
"""Half a step, by which rounding moves a reading at most, and what a curved line adds."""
ENOUGH_OFF = 4
"""Mean readings beyond those that lines go through, which say that a display is all the noise."""
NAMED = 4
"""Channels named one by one in a sentence about many."""


@dataclass(frozen=True, slots=True, eq=False)
class Checked:
    """A campaign without what its channels do wrong.

    Attributes
    ----------
    campaign, predicted
        what is left, and what the twin says of its rows (n_rows, n_gauges).
    faults
        what is left out.
    outliers
        by gauge with far-off readings, their share.
    is_one_sided
        whether far-off readings lie to one side.
    """

    campaign: Campaign
    predicted: Floats
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


def checked(campaign: Campaign, twin: Twin) -> Checked:
    """Return the campaign without what its channels do wrong beside the twin.

    Channels of which nothing is left are no longer in it.

    Raises
    ------
    DataError
        nothing is left.
    """
    left, faults, predicted = campaign, list[Fault](), _predicted(campaign, twin)
    for look in (partial(stuck_in, predicted=predicted), partial(clipped_in, predicted=predicted), jumps_in):
        found = look(left)
        left = _without(left, found)
        faults += found
    left = counted_once(left)
    sturdy = robust(left)
    left = _without_silent(replace(left, readings=sturdy.readings), campaign)
    return Checked(left, _predicted(left, twin), tuple(faults), sturdy.share, sturdy.is_one_sided)


def _predicted(campaign: Campaign, twin: Twin) -> Floats:
    """Return what the twin says of every row (n_rows, n_gauges), unknown states healthy; NaN of gauges it lacks."""
    known = [k for k, name in enumerate(campaign.gauges) if name in twin.gauges]
    order = [twin.gauges.index(campaign.gauges[k]) for k in known]
    predicted = np.full_like(campaign.readings, np.nan)
    for cell in campaign.cells:
        state = {name: v for name, v in zip(campaign.parameters, cell.state.tolist(), strict=True) if not np.isnan(v)}
        predicted[np.ix_(cell.rows, np.array(known, dtype=np.int64))] = twin.predict(state, cell.load)[order]
    return predicted


def calm(run: Campaign, twin: Twin) -> Campaign:
    """Return a commissioning run without what its channels do wrong beside the twin, its gauges all kept.

    It began with gauges at zero, so what a gauge shows after a jump is left out.
    """
    found = checked(run, twin)
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
    """Return the noise with what the channels do wrong, and notes on where it is from.

    Raises
    ------
    DataError
        there are no repeats, or none differ and no display explains it.
    """
    noise, notes = _from_repeats_or_known(checks, run, noise_sd)
    properties = tuple(dict.fromkeys((*noise.properties, *checks.findings)))
    return replace(noise, faults=checks.faults, properties=properties), notes


def _from_repeats_or_known(
    checks: Checked, run: Campaign | None, noise_sd: float | Mapping[str, float] | None
) -> tuple[Noise, list[str]]:
    """Return the noise and where it is from: the repeats, what is given, the commissioning run or the display."""
    campaign = checks.campaign
    given = None if noise_sd is None else given_noise(campaign.gauges, noise_sd)
    if campaign.has_repeats and campaign.scatters:
        unused = "The noise is estimated from the repeats; the given standard deviation is not used."
        return estimate_noise(campaign, run), [] if given is None else [unused]
    why = "No repeats differ; " if campaign.has_repeats else "Every test holds too few repeats to estimate the noise; "
    if given is not None:
        return given, [why + "the given standard deviation is taken as known."]
    if run is not None and run.has_repeats and run.scatters:
        return estimate_noise(campaign, run).of_gauges(campaign.gauges), [
            why + "the commissioning run's noise is used."
        ]
    noise = estimate_noise(campaign, run)
    if not _is_explained(campaign, checks.predicted, noise.steps):
        raise DataError(
            f"all repeats of each of {len(campaign.gauges)} gauges are equal, and no step of a display explains it; "
            "expected noise; keep one of rows that are copies, and give the standard deviation of one reading "
            "(noise_sd, --noise)"
        )
    step = f"{noise.step:g}"
    return noise, [f"{why}the noise is taken as that of the display, whose steps are {step} (typical gauge)."]


def _is_explained(campaign: Campaign, predicted: Floats, steps: Floats) -> bool:
    """Return whether each gauge's readings lie within half a step of a line over what the twin (n_rows, n_gauges) says.

    Copies of readings with noise lie farther from it. One reading beyond the two that a line needs says little, so
    `ENOUGH_OFF` of all gauges are asked for.
    """
    first = np.array([cell.rows[0] for cell in campaign.cells])
    beyond = 0
    for k, step in enumerate(steps.tolist()):
        x, y = predicted[first, k], np.array([cell.mean[k] for cell in campaign.cells])
        x, y = x[np.isfinite(y)], y[np.isfinite(y)]
        if len(np.unique(x)) < 3:
            continue
        beyond += len(x) - 2
        if np.abs(y - np.polyval(np.polyfit(x, y, 1), x)).max() > HALF * step:
            return False
    return beyond >= ENOUGH_OFF


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
    if run.has_repeats and run.scatters:
        return estimate_noise(run).of_gauges(known.gauges), []
    note = "The commissioning run holds too few repeats that differ to estimate its noise; the campaign's is used."
    return replace(known, faults=()), [note]
