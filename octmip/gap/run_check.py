"""The check of a commissioning run: the asset may not have been sound, or not as it is today, when it was read.

A calibration hides whatever was wrong on its day, and accuses the sound asset of the opposite. Three things show it: a
run does not grow with the load as the twin does (a temperature, a bias), or it differs from the twin by more than two
models of one structure do, in a pattern that a damage explains: then the run is itself diagnosed, as a campaign without
a run, and what leads is said. Or the asset is accused of what a fault of the run explains as well, beside a difference
of twin and asset that is more usual (`octmip.gap.run_evidence`).
"""

from collections.abc import Mapping
from dataclasses import dataclass

from octmip.gap.campaign.campaign import Campaign
from octmip.gap.causes import MISSTATED, UNKNOWN, Cause, causes_of
from octmip.gap.inference.discrepancy import Discrepancy
from octmip.gap.inference.inputs import prepare
from octmip.gap.inference.posterior import Posterior, attribute
from octmip.gap.inference.states import state_posterior
from octmip.gap.odds import Differences, Odds
from octmip.gap.run_evidence import wrong_run
from octmip.gap.twins.cached import CachedTwin
from octmip.twin import Effect

UNUSUAL = 2.0 * Differences().spread
"""Relative difference of healthy readings, one sd, from which a run is looked at more closely: .028."""
TOO_FAR = 3.2 * Differences().spread
"""The same from which no two models of one structure differ so much, whatever is said to be usual: .045."""
POSSIBLE = 0.1
"""Probability from which a run that may be wrong is mentioned."""
LIKELY = 0.5
"""Probability from which what leads is said of a run."""


@dataclass(frozen=True, slots=True)
class RunCheck:
    """What speaks against a commissioning run.

    Attributes
    ----------
    sentences
        for the reader; empty where nothing does.
    is_usable
        whether it calibrates the twin all the same.
    remarks
        what may speak against it, though less probably than not.
    """

    sentences: tuple[str, ...] = ()
    is_usable: bool = True
    remarks: tuple[str, ...] = ()


def check_of(
    run: Campaign,
    twin: CachedTwin,
    effects: Mapping[str, Effect],
    known: Discrepancy,
    noise_sd: float | Mapping[str, float] | None,
    odds: Odds,
) -> RunCheck:
    """Return what speaks against a commissioning run that left the discrepancy `known`."""
    apart = known.own_level * known.usual.spread
    if known.uneven <= LIKELY and apart < UNUSUAL:
        return RunCheck()
    inputs, _ = prepare(run, twin, effects, None, noise_sd, odds=odds)
    posterior = attribute(inputs, is_quick=True)
    misstated = sum(h.probability for h in posterior.judged if h.doubted)
    first = causes_of(posterior)[0]
    if misstated > LIKELY and MISSTATED in first.effects:
        return RunCheck((f"{_LEAD}: its readings are those of {_state_of(first)}; it is left out.",), False)
    if apart > TOO_FAR:
        return RunCheck((f"{_LEAD}: it differs from the twin by more than two models do; it is left out.",), False)
    if known.uneven > LIKELY and first.effects and first.probability > LIKELY:
        return RunCheck((f"{_LEAD}: it does not grow with the load as the twin does ({_called(first)}).",))
    return RunCheck()


def check_beside(
    posterior: Posterior,
    run: Campaign,
    effects: Mapping[str, Effect],
    noise_sd: float | Mapping[str, float] | None,
    odds: Odds,
) -> RunCheck:
    """Return what speaks against a run beside which the asset is accused: it may be the run that is wrong."""
    sound = sum(h.probability for h in posterior.judged if not h.members and not h.has_unknown and not h.doubted)
    if sound > LIKELY:
        return RunCheck()
    found = wrong_run(posterior, run, effects, noise_sd, odds)
    if found.probability <= LIKELY:
        remark = (
            f"It may also be the commissioning run that is wrong (probability {found.probability:.2f}): {found.what}."
        )
        return RunCheck(remarks=(remark,) if found.probability > POSSIBLE else ())
    return RunCheck((f"{_LEAD}: {found.what}; it is left out.",), False)


_LEAD = "The commissioning run is doubtful"


def _state_of(cause: Cause) -> str:
    """Return the state that a misstated test seems to be in, in words."""
    judged = cause.judged
    mean, _ = state_posterior(judged.allowing, judged.fit)
    named = judged.model.inputs.named(mean[: len(judged.model.inputs.names)])
    return " and ".join(f"{name} {max(0.0, value):.2f}" for name, value in named.items())


def _called(cause: Cause) -> str:
    """Return what a cause is called."""
    named = [parameter.named.name for parameter in cause.parameters]
    return " and ".join([*named, *["something outside the library"] * (UNKNOWN in cause.effects)]) or "a small effect"
