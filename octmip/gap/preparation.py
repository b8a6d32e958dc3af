"""What a diagnosis starts from: the model within its budget, the constants of the asset, and what is looked for."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from octmip.errors import DataError, TwinError
from octmip.gap.campaign.campaign import Campaign
from octmip.gap.doors.budget import Budget, within
from octmip.gap.doors.built import as_built, built_words
from octmip.gap.doors.function import FunctionTwin
from octmip.gap.effects import chain_of
from octmip.gap.effects.families import History
from octmip.gap.effects.simple import SimpleEffect
from octmip.gap.inference.inputs import WITHOUT_RUN, Inputs, prepare
from octmip.gap.inference.signatures import load_steps
from octmip.gap.odds import Odds
from octmip.gap.twins import CachedTwin
from octmip.twin import MICROSTRAIN, Effect, Twin, units_of

MOST_TESTS = 3
"""Tests of a campaign up to which an effect may have a size of its own in each: no larger sets are looked for."""
WARMER = 1.0
"""Range of the temperature [K] from which readings may go with it."""


def within_budget(twin: Twin, campaigns: Sequence[Campaign], budget: Budget | None) -> tuple[CachedTwin, list[str]]:
    """Return the twin with its answers kept, which keeps within a budget of questions, and notes."""
    asked = twin if isinstance(twin, CachedTwin) else CachedTwin(twin)
    if budget is None:
        return asked, []
    if not isinstance(asked.twin, FunctionTwin):
        raise DataError(f"a budget of calls was given for {asked.name}; expected a function or a table; leave it out")
    stand_in, notes = within(asked.twin, campaigns, budget)
    found = CachedTwin(stand_in)
    found.units = asked.units
    return found, notes


def inputs_of(
    campaign: Campaign,
    asked: CachedTwin,
    effects: Mapping[str, Effect] | None,
    noise_sd: float | Mapping[str, float] | None,
    odds: Odds,
    run: Campaign | None,
    is_right: bool = True,
) -> tuple[Inputs, list[str]]:
    """Return the inputs of the inference beside a run, and notes; of a run that is not right the noise alone counts."""
    share = odds.differences.constants
    right = run if is_right else None
    sound = as_built(asked, right or campaign, share, is_open=right is None)
    chosen = effects if effects is not None else library_of(sound, campaign)
    own, there = getattr(asked, "effects", {}), getattr(sound, "effects", {})
    chosen = {key: there[key] if effect is own.get(key) else effect for key, effect in chosen.items()}
    chosen, lost = _answered(_by_test(chosen, campaign), sound, campaign)
    inputs, notes = prepare(campaign, sound, chosen, run, noise_sd, odds)
    if not is_right:
        inputs = replace(inputs, run=None)
        inputs = replace(inputs, difference=inputs.usual)
    if right is not None:
        return inputs, [*lost, *built_words(asked, sound), *notes]
    return inputs, [*lost, *(note for note in notes if note != WITHOUT_RUN or not inputs.open)]


def _by_test(effects: Mapping[str, Effect], campaign: Campaign) -> dict[str, Effect]:
    """Return the effects, those of the whole also with sizes of their own in each of few tests: they may grow."""
    tests = tuple(dict.fromkeys(cell.test for cell in campaign.cells))
    changes = {
        key: replace(effect, tests=tests)
        for key, effect in effects.items()
        if isinstance(effect, SimpleEffect) and effect.at == ("",) and 1 < len(tests) <= MOST_TESTS
    }
    return {**effects, **changes}


def _answered(
    effects: Mapping[str, Effect], sound: CachedTwin, campaign: Campaign
) -> tuple[dict[str, Effect], list[str]]:
    """Return the effects but for parameters at whose other values a model fails, and a note on each of these."""
    ranges = sound.twin.card.ranges if isinstance(sound.twin, FunctionTwin) else {}
    kept, notes = dict(effects), []
    for key, effect in effects.items():
        try:
            for cell in campaign.cells if getattr(effect, "name", "") in ranges else ():
                if cell.is_known:
                    state = dict(zip(campaign.parameters, cell.state.tolist(), strict=True))
                    sound.signatures(effect, tuple(effect.places(sound)), state, cell.load, cell.time)
        except TwinError as error:
            del kept[key]
            notes.append(f"The parameter {effect.name} is left out: {error}.")
    return kept, notes


def library_of(twin: Twin, campaign: Campaign) -> dict[str, Effect]:
    """Return the effects that are looked for where none are given: the measuring chain's and the twin's own."""
    extents = dict(zip(campaign.load_names, np.ptp(campaign.applied, axis=0).tolist(), strict=True))
    chain = chain_of(twin, _typical(campaign, twin), _histories(campaign), extents)
    return {**chain, **getattr(twin, "effects", {})}


def _histories(campaign: Campaign) -> dict[str, History]:
    """Return the courses of a campaign's own time: its temperature in 10 K, and which way the load went last."""
    found: dict[str, History] = {}
    if not campaign.has_time:
        return found
    start = float(campaign.time.min())
    seen = np.flatnonzero(np.isfinite(campaign.temperature))
    if len(seen) and np.ptp(campaign.temperature[seen]) > WARMER:
        order = seen[np.argsort(campaign.time[seen], kind="stable")]
        above = (campaign.temperature[order] - campaign.temperature[order[0]]) / 10.0
        found["warming"] = tuple(zip((campaign.time[order] - start).tolist(), above.tolist(), strict=True))
    signs = np.sign([change for change, _ in load_steps(campaign)])
    if 1.0 in signs and -1.0 in signs:
        times = [time for _, time in load_steps(campaign)]
        found["direction"] = tuple(zip(times, signs.tolist(), strict=True))
    return found


def _typical(campaign: Campaign, twin: Twin) -> dict[str, float]:
    """Return the root mean square of the campaign's readings of each unit."""
    units = dict(zip(twin.gauges, units_of(twin), strict=True))
    squares: dict[str, list[float]] = {}
    for k, name in enumerate(campaign.gauges):
        own = campaign.readings[:, k]
        squares.setdefault(units.get(name, MICROSTRAIN), []).extend((own[np.isfinite(own)] ** 2).tolist())
    return {unit: float(np.sqrt(np.mean(values))) if values else 1.0 for unit, values in squares.items()}
