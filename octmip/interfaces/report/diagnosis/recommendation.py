"""The first sentence of a diagnosis: what to do. One rule for each verdict, the first that holds applies.

| verdict | holds where | sentence |
|---|---|---|
| unexplained | the first cause is, or has beside it, something outside the library | Stop: ... inspect ... |
| unmeasured | the first cause is no effect, but readings and twin differ, without a run | Cannot be told: ... |
| sound | the first cause is no effect | Nothing to do: ... |
| too small | some effect acts, but none stands d' = 3 above the noise | Nothing to do yet: ... |
| hidden | an unknown damage could make the same readings as an effect of it | Cannot be told: ... |
| ambiguous | another effect has `RIVAL` of its probability, or it less than `ENOUGH` | Cannot be told, Check gauge |
| cause | none of these | what to do about each effect, its size, interval and probability |

Channels that are stuck or clipped are named in the same sentence whatever the verdict: they are to be repaired first.
"""

from enum import StrEnum

from octmip.gap.causes import ENOUGH, MISFIT, UNKNOWN, Cause, Certainty, ConfoundedEffects
from octmip.gap.diagnosis import BASELINE, Diagnosis
from octmip.input.names import visible
from octmip.interfaces.report.diagnosis.phrases import (
    about,
    amount,
    brief_words,
    cause_names,
    finding_words,
    listed,
    with_unit,
)

RIVAL = 0.05
"""Share of a cause's probability from which an effect that cannot be told from it is named beside it."""
CLEARLY = 3.0
"""Sds that a constant must be off the drawing to be told first."""
FEW = 3
"""Names that a sentence lists."""
MORE = "repeat the test with more readings"


DIFFERENT = 0.01
"""Probability of a gap as great between a sound asset and its twin, below which "nothing to do" needs a run."""


class Verdict(StrEnum):
    """The kinds of verdict, in the order in which their rules are tried."""

    UNEXPLAINED = "unexplained"
    UNMEASURED = "unmeasured"
    SOUND = "sound"
    TOO_SMALL = "too small"
    HIDDEN = "hidden"
    AMBIGUOUS = "ambiguous"
    CAUSE = "cause"


def verdict_of(diagnosis: Diagnosis) -> Verdict:
    """Return the kind of verdict."""
    first = diagnosis.which[0]
    if UNKNOWN in first.effects:
        return Verdict.UNEXPLAINED
    if not first.effects:
        return Verdict.UNMEASURED if _is_unmeasured(diagnosis) else Verdict.SOUND
    if not first.is_identifiable:
        return Verdict.TOO_SMALL
    if _hidden(diagnosis):
        return Verdict.HIDDEN
    if first.certainty is Certainty.OPEN or _rivals(first):
        return Verdict.AMBIGUOUS
    return Verdict.CAUSE


def recommend(diagnosis: Diagnosis) -> str:
    """Return what to do, as one sentence."""
    sentence = {
        Verdict.UNEXPLAINED: _stop,
        Verdict.UNMEASURED: _bring_a_run,
        Verdict.SOUND: _nothing,
        Verdict.TOO_SMALL: _not_yet,
        Verdict.HIDDEN: _between_damage_and_effect,
        Verdict.AMBIGUOUS: _cannot_be_told,
        Verdict.CAUSE: _act,
    }[verdict_of(diagnosis)](diagnosis)
    off = _constants(diagnosis)
    if off and verdict_of(diagnosis) in (Verdict.SOUND, Verdict.UNMEASURED):
        sentence = f"{off} in the drawing: built so, or changed since; a run of the sound asset (--commissioning) tells"
    elif off:
        sentence = f"{sentence}; built so, or changed since: {off} in the drawing"
    return visible(_capital("; ".join([*_channels(diagnosis), sentence])) + ".")


def _capital(sentence: str) -> str:
    return sentence[:1].upper() + sentence[1:]


def _channels(diagnosis: Diagnosis) -> list[str]:
    """Return what to do about channels whose readings say nothing about the structure."""
    noise = diagnosis.noise
    parts = []
    if noise.stuck:
        parts.append(f"repair the {_channel(list(noise.stuck))}, whose readings do not follow the load")
    if noise.clipped:
        unit_of = diagnosis.posterior.model.inputs.campaign.unit_of
        ends = [f"{name} ends at {with_unit(f'{end:g}', unit_of(name))}" for name, end in noise.clipped.items()]
        more = f" (and {len(ends) - FEW} more)" if len(ends) > FEW else ""
        parts.append(f"widen the range of the {_channel(list(noise.clipped))}: {listed(ends[:FEW])}{more}")
    return parts


def _constants(diagnosis: Diagnosis) -> str:
    """Return which constants the readings put clearly off the drawing, where no run says how the asset was built."""
    far = [(abs(one.mean - one.drawn) / one.sd, one) for one in diagnosis.constants]
    off = [one for z, one in sorted(far, key=lambda pair: -pair[0])[:FEW] if z > CLEARLY]
    said = [
        f"{one.name.replace('_', ' ')} is {with_unit(f'{one.mean:.4g}', one.unit)} for {one.drawn:g}" for one in off
    ]
    return listed(said) if said else ""


def _channel(gauges: list[str]) -> str:
    return f"channel of gauge {gauges[0]}" if len(gauges) == 1 else f"channels of gauges {listed(gauges)}"


def _stop(diagnosis: Diagnosis) -> str:
    found = [place.name for place in diagnosis.where.gauges if place.is_significant][:FEW]
    places = f"gauge{'s' if len(found) > 1 else ''} {listed(found)} and the structure there" if found else "the asset"
    chance = about(diagnosis.unknown_probability)
    return (
        f"stop: the gap is explained by nothing in the library (probability {chance}); inspect {places} before relying "
        "on the twin"
    )


def _is_unmeasured(diagnosis: Diagnosis) -> bool:
    """Return whether readings and twin differ by more than chance, and nothing says whether they always did."""
    return diagnosis.posterior.model.inputs.run is None and diagnosis.where.p_value < DIFFERENT


def _bring_a_run(diagnosis: Diagnosis) -> str:
    where = diagnosis.where
    return (
        f"cannot be told: readings and twin differ by {amount(where.rms, where.unit)} root mean square, most at gauge "
        f"{where.gauges[0].name} (p-value {where.p_value:.2g}), and no effect of the library explains it; bring a run "
        "of the sound asset (--commissioning), which says whether the twin was always off by as much"
    )


def _nothing(diagnosis: Diagnosis) -> str:
    chance = about(diagnosis.which[0].probability)
    return f"nothing {_else(diagnosis)}to do: no effect larger than the detectable sizes below (probability {chance})"


def _else(diagnosis: Diagnosis) -> str:
    return "else " if _channels(diagnosis) else ""


def _not_yet(diagnosis: Diagnosis) -> str:
    chance = about(sum(cause.probability for cause in diagnosis.which if cause.effects))
    test = diagnosis.next_test[0].words if diagnosis.next_test else MORE
    return (
        f"nothing {_else(diagnosis)}to do yet: some effect is there (probability {chance}), too small to name in these "
        f"readings; the next test: {test}"
    )


def _separated(diagnosis: Diagnosis, otherwise: str = MORE) -> str:
    if diagnosis.next_test:
        return f"the next test that separates them: {diagnosis.next_test[0].words}"
    return f"to separate them: {otherwise}"


def _hidden(diagnosis: Diagnosis) -> list[str]:
    """Return the effects of the first cause that an unknown damage could imitate."""
    if not diagnosis.states:
        return []
    refused = diagnosis.refused
    parameters = diagnosis.which[0].parameters
    return [p.named.name for p in parameters if "an unknown damage" in refused.get(p.effect, "")]


def _between_damage_and_effect(diagnosis: Diagnosis) -> str:
    test = BASELINE.removesuffix(" would separate them")
    return (
        f"cannot be told: {listed(_hidden(diagnosis), 'or')} or a damage of the structure; the next test that "
        f"separates them: {test}"
    )


def _rivals(cause: Cause) -> list[ConfoundedEffects]:
    """Return the effects of a cause that another one may stand for, in earnest."""
    return [found for found in cause.confounded if max(found.shares[1:], default=0.0) >= RIVAL]


def _rival_names(cause: Cause, found: ConfoundedEffects) -> list[str]:
    """Return an effect with its size, and what may stand for it, the most probable first."""
    own = (found.effects[0], found.places[0])
    parameter = next(p for p in cause.parameters if (p.effect, p.place) == own)
    rivals = sorted(zip(found.shares[1:], found.words[1:], strict=True), key=lambda pair: -pair[0])
    names = [brief_words(parameter), *(words for share, words in rivals if share >= RIVAL)]
    names = list(dict.fromkeys(names))
    return names if len(names) <= FEW + 1 else [*names[:FEW], "another effect"]


def _gauge_of(cause: Cause, found: ConfoundedEffects) -> str:
    """Return the gauge whose readings all of these effects change, "" where there is no such gauge."""
    inputs = cause.judged.model.inputs
    effects = {candidate.name: candidate.effect for candidate in inputs.candidates}
    first = set()
    for k, (name, place) in enumerate(zip(found.effects, found.places, strict=True)):
        own = getattr(effects[name], "gauges_of", None)
        if k == 0 or found.shares[k] >= RIVAL:
            first.add(next(iter(own(inputs.twin, place))) if own is not None and place else "")
    return str(first.pop()) if len(first) == 1 else ""


def _cannot_be_told(diagnosis: Diagnosis) -> str:
    first = diagnosis.which[0]
    rivals = _rivals(first)
    if first.probability < ENOUGH or not rivals:
        return _between_causes(diagnosis)
    choices = "; and ".join(listed(_rival_names(first, found), "or") for found in rivals)
    gauges = {_gauge_of(first, found) for found in rivals}
    named = {(found.effects[0], found.places[0]) for found in rivals}
    clear = [_told(first, k) for k, p in enumerate(first.parameters) if (p.effect, p.place) not in named]
    beside = f"; certain beside it: {'; '.join(clear)}" if clear else ""
    separated = rivals[0].separated_by[0]
    if len(gauges) == 1 and (gauge := gauges.pop()):
        return (
            f"check gauge {gauge}: {choices}, which these readings cannot tell apart (probability "
            f"{about(first.probability)} that it is one of them){beside}; {_separated(diagnosis, separated)}"
        )
    return (
        f"cannot be told: {choices} (probability {about(first.probability)} that it is one of them){beside}; "
        f"{_separated(diagnosis, separated)}"
    )


def _between_causes(diagnosis: Diagnosis) -> str:
    shown = [c for c in diagnosis.credible if c.probability >= RIVAL][:FEW] or list(diagnosis.which[:FEW])
    choices = [f"{cause_names(cause)} (probability {about(cause.probability)})" for cause in shown]
    if len(choices) == 1:
        choices.append("another cause")
    return f"cannot be told: {listed(choices, 'or')}; {_separated(diagnosis)}"


def _told(cause: Cause, k: int) -> str:
    parameter = cause.parameters[k]
    return f"{parameter.named.action}: {finding_words(parameter)}"


def _act(diagnosis: Diagnosis) -> str:
    first = diagnosis.which[0]
    found = [_told(first, k) for k in range(len(first.parameters))]
    parts = "; and ".join(found)
    s = diagnosis.shrinkage
    end = "nothing else is needed"
    if s is not None and s.p_after < MISFIT:
        end = "something smaller remains that no effect of the library describes"
    elif alike := [words for found in first.confounded for words in found.words[1:]]:
        end = f"far less probably {listed(alike[:FEW], 'or')}, which these readings cannot tell from it"
    return f"{parts}, probability {about(first.probability)} ({first.certainty}); {end}"
