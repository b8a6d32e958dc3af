"""Where the noise of a campaign is from: its repeats, the commissioning run's, or what is known of the instrument."""

from collections.abc import Mapping
from dataclasses import replace

from octmip.gap.campaign.campaign import Campaign
from octmip.gap.campaign.noise import Noise, estimate_noise, given_noise


def noise_of(
    campaign: Campaign,
    run: Campaign | None,
    rails: Mapping[str, float],
    noise_sd: float | Mapping[str, float] | None,
) -> tuple[Noise, list[str]]:
    """Return the noise with what is clipped, and notes on where it is from and on stuck channels."""
    noise, notes = _from_repeats_or_known(campaign, run, noise_sd)
    if rails:
        noise = replace(noise, clipped=rails, findings=(*noise.findings, "clipping"))
    if noise.stuck:
        notes.append(f"Readings of {', '.join(noise.stuck)} never change between repeats: a stuck channel.")
    return noise, notes


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
