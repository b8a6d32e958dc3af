"""Where the noise of a campaign is from: its repeats, the commissioning run's, or what is known of the instrument."""

from collections.abc import Mapping
from dataclasses import replace

from octmip.errors import DataError
from octmip.gap.campaign.campaign import Campaign
from octmip.gap.campaign.noise import Noise, given_noise
from octmip.gap.campaign.noise_estimate import estimate_noise
from octmip.gap.channels.checks import Checked


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
