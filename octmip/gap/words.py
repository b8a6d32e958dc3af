"""The diagnosis as a page of words for a test engineer, and as one JSON object for machines."""

import math
from collections.abc import Sequence
from typing import Any

from octmip.gap.causes import MISFIT, UNKNOWN, Cause, Parameter
from octmip.gap.diagnosis import Diagnosis
from octmip.gap.location import Place

FEW = 5
"""Places of one kind that a page lists."""


def page_of_words(diagnosis: Diagnosis) -> str:
    """Return the page: the verdict first, then where, which, how far, what next, noise, notes."""
    parts = [
        verdict(diagnosis),
        _section("Where", _where(diagnosis)),
        _section("Which", _which(diagnosis)),
        _section("How far", _how_far(diagnosis)),
        _section("Next test", _next(diagnosis)),
        _section("Noise", _noise(diagnosis)),
    ]
    if diagnosis.states:
        parts.append(_section("Unknown states", _state_lines(diagnosis)))
    if diagnosis.notes:
        parts.append(_section("Notes", list(diagnosis.notes)))
    return "\n\n".join(parts)


def verdict(diagnosis: Diagnosis) -> str:
    """Return one sentence that answers the question."""
    first = diagnosis.which[0]
    chance = likely(first.probability)
    if diagnosis.is_sound:
        return f"Sound: the twin explains these readings without any further effect (probability {chance})."
    if UNKNOWN in first.effects:
        best = next((c for c in diagnosis.which if c.effects and UNKNOWN not in c.effects), None)
        tried = (
            f" The best that the library offers, {cause_words(best)}, does not explain the readings." if best else ""
        )
        return (
            f"Unexplained: something outside the library acts (probability {likely(diagnosis.unknown_probability)}); "
            f"it looks like {diagnosis.posterior.unknown.words}.{tried}"
        )
    return f"The twin lacks {cause_words(first)} (probability {chance})."


def cause_words(cause: Cause) -> str:
    """Return the effects of a cause with size and interval, and what cannot be told from them."""
    if not cause.effects:
        return "nothing: no effect"
    if UNKNOWN in cause.effects:
        return "something outside the library"
    if not cause.is_clear:
        return f"some effect too small to name in these readings ({' + '.join(cause.effects)} or another)"
    told = []
    for parameter in cause.parameters:
        tie = next((t for t in cause.ties if t.effects[0] == parameter.effect), None)
        others = f", or as well {' or '.join(tie.effects[1:])}" if tie else ""
        told.append(f"{size_words(parameter)}{others}")
    return " and ".join(told)


def size_words(parameter: Parameter) -> str:
    """Return an effect with its place, size and 90 % interval."""
    place = f" at {parameter.variant}" if parameter.variant else ""
    interval = f"{parameter.low:.3g} to {parameter.high:.3g}"
    return f"{parameter.effect}{place}: {parameter.size:.3g} {parameter.unit} (90 % {interval})"


def percent(share: float) -> str:
    """Return a probability or share in per cent, never rounded to certainty."""
    if math.isnan(share):
        return "not defined"
    if share > 0.999 and share < 1.0:
        return "over 99.9 %"
    return f"{100 * share:.1f} %" if share >= 0.001 or share == 0 else "under 0.1 %"


def likely(probability: float) -> str:
    """Return a probability in per cent, never certainty."""
    return "over 99.9 %" if probability > 0.999 else percent(probability)


def _section(title: str, lines: Sequence[str]) -> str:
    return "\n".join([title, *(f"  {line}" for line in lines)])


def _where(diagnosis: Diagnosis) -> list[str]:
    where = diagnosis.where
    clear = [entry for entry in where.entries if entry.is_significant]
    lines = [
        f"Gap of {where.rms_microstrain:.1f} microstrain root mean square beyond noise; {len(clear)} of "
        f"{len(where.entries)} mean readings differ clearly (false-discovery rate 5 %); chance of no gap at all "
        f"{where.p_value:.2g}."
    ]
    for kind, places in (("gauges", where.gauges), ("loads", where.loads), ("tests", where.tests)):
        worth = [place for place in places if place.is_significant][:FEW]
        if worth:
            lines.append(f"By {kind}: {'; '.join(_place(place) for place in worth)}.")
    for flip in where.nodes[:FEW]:
        lines.append(
            f"Tree node {flip.path or 'root'} ({flip.words}): {percent(flip.share)} of all readings go the other way "
            f"(left {percent(flip.simulated)} in the twin, {percent(flip.real)} in the asset)."
        )
    return lines


def _place(place: Place) -> str:
    return f"{place.name} {place.gap_microstrain:+.1f} microstrain, {percent(max(0.0, place.share))} of the gap"


def _which(diagnosis: Diagnosis) -> list[str]:
    lines: list[str] = []
    for cause in diagnosis.which[:FEW]:
        if cause.probability < 0.005 and lines:
            break
        lines.append(f"{likely(cause.probability):>11}  {cause_words(cause)}")
        if cause is diagnosis.which[0]:
            lines += [f"            cannot be told apart: {' / '.join(t.effects)}: {t.reason}" for t in cause.ties]
    if diagnosis.which[0].is_prior_sensitive:
        lines.append(
            "Prior-sensitive: another cause would lead if all effects were thought three times smaller or larger."
        )
    lines.append(f"Something outside the library: {likely(diagnosis.unknown_probability)}.")
    if diagnosis.is_sound:
        lines.append(f"These readings would have shown, with 95 % power: {_limits(diagnosis)}.")
    lines += [f"No statement on {name}: {reason}." for name, reason in list(diagnosis.refused.items())[:FEW]]
    return lines


def _limits(diagnosis: Diagnosis) -> str:
    units = {c.name: c.effect.unit for c in diagnosis.posterior.scene.setting.columns if not c.is_fact}
    told = [(n, s) for n, s in diagnosis.detectable.items() if n in units and n not in diagnosis.refused]
    return ", ".join(f"{name} {size:.2g} {units[name]}" for name, size in told)


def _how_far(diagnosis: Diagnosis) -> list[str]:
    s = diagnosis.shrinkage
    if s is None:
        return ["No effect was added, so nothing closes."]
    lines = [
        f"Held-out gap {s.before:.1f} -> {s.after:.1f} microstrain (floor of two good models {s.floor:.1f}): "
        f"{percent(s.closed)} of the squared gap closed (90 % {percent(s.low)} to {percent(s.high)}).",
        f"Chi-squared per reading {s.chi2_before:.2f} -> {s.chi2_after:.2f} (chance of what remains {s.p_after:.2g}).",
    ]
    if s.p_after < MISFIT:
        lines.append("Something that no cause of the library describes remains in the readings.")
    lines += [f"{h.name} held out: {h.before:.1f} -> {h.after:.1f} microstrain" for h in s.held_out]
    return lines


def _next(diagnosis: Diagnosis) -> list[str]:
    if not diagnosis.next_test:
        return ["Little doubt is left among the effects of the library; no further test is needed."]
    lines = [
        f"{p.words} ({p.name}): about {p.information / math.log(2):.2f} bits at cost {p.cost:g}"
        for p in diagnosis.next_test[:4]
    ]
    if not any(p.is_strain_test for p in diagnosis.next_test):
        lines.append("No strain test can help: the open effects change every strain in the same way.")
    return lines


def _noise(diagnosis: Diagnosis) -> list[str]:
    noise = diagnosis.noise
    lines = [
        f"One reading scatters by {noise.sd_microstrain:.1f} microstrain (typical gauge; variance "
        f"{noise.sd_microstrain**2:.0f}); lag-1 correlation {noise.lag1:.2f}, excess kurtosis {noise.kurtosis:.2f}, "
        f"step {noise.step:g} microstrain."
    ]
    if noise.inflation > 1.0:
        lines.append(
            f"Successive readings are correlated: a mean is {noise.inflation:.1f} times as uncertain (variance)."
        )
    if noise.findings:
        lines.append(f"Not plain white noise: {', '.join(noise.findings)}.")
    return lines


def _state_lines(diagnosis: Diagnosis) -> list[str]:
    return [
        f"{', '.join(s.tests)}: " + ", ".join(f"{n} {s.mean[n]:.3f} +- {s.sd[n]:.3f}" for n in s.mean)
        for s in diagnosis.states
    ]


def as_object(diagnosis: Diagnosis) -> dict[str, Any]:
    """Return the diagnosis as one JSON object; the keys are stable, numbers that do not exist are null."""
    s = diagnosis.shrinkage
    where = diagnosis.where
    noise = diagnosis.noise
    content = {
        "verdict": verdict(diagnosis),
        "is_sound": diagnosis.is_sound,
        "where": {
            "rms_microstrain": where.rms_microstrain,
            "p_value": where.p_value,
            "entries": [_place_object(p) for p in where.entries if p.is_significant],
            "gauges": [_place_object(p) for p in where.gauges],
            "loads": [_place_object(p) for p in where.loads],
            "tests": [_place_object(p) for p in where.tests],
            "nodes": [
                {"path": f.path, "split": f.words, "simulated": f.simulated, "real": f.real, "share": f.share}
                for f in where.nodes
            ],
        },
        "which": [_cause_object(cause) for cause in diagnosis.which],
        "credible_set": [list(cause.effects) for cause in diagnosis.credible],
        "inclusion": diagnosis.inclusion,
        "ambiguity": [
            {
                "effects": list(t.effects),
                "places": list(t.places),
                "d_prime": list(t.d_prime),
                "reason": t.reason,
            }
            for t in diagnosis.ambiguity
        ],
        "parameters": [_parameter_object(p) for p in diagnosis.which[0].parameters],
        "unknown_probability": diagnosis.unknown_probability,
        "detectable": diagnosis.detectable,
        "refused": diagnosis.refused,
        "noise": {
            "sd_microstrain": noise.sd_microstrain,
            "variance": noise.sd_microstrain**2,
            "lag1": noise.lag1,
            "inflation": noise.inflation,
            "kurtosis": noise.kurtosis,
            "step_microstrain": noise.step,
            "variance_ratio_by_load": {f"{load:g}": ratio for load, ratio in noise.scale.items()},
            "stuck": list(noise.stuck),
            "findings": list(noise.findings),
        },
        "shrinkage": None
        if s is None
        else {
            "before_microstrain": s.before,
            "after_microstrain": s.after,
            "floor_microstrain": s.floor,
            "closed": s.closed,
            "low": s.low,
            "high": s.high,
            "chi2_before": s.chi2_before,
            "chi2_after": s.chi2_after,
            "held_out": [
                {"name": h.name, "before": h.before, "after": h.after, "closed": h.closed} for h in s.held_out
            ],
        },
        "next_test": [
            {
                "name": p.name,
                "words": p.words,
                "information_nats": p.information,
                "cost": p.cost,
                "is_strain_test": p.is_strain_test,
            }
            for p in diagnosis.next_test
        ],
        "states": [{"tests": list(e.tests), "mean": e.mean, "sd": e.sd} for e in diagnosis.states],
        "notes": list(diagnosis.notes),
    }
    finite: dict[str, Any] = _finite(content)
    return finite


def _cause_object(cause: Cause) -> dict[str, Any]:
    return {
        "effects": list(cause.effects),
        "probability": cause.probability,
        "parameters": [_parameter_object(p) for p in cause.parameters],
        "cannot_be_told_from": [list(t.effects[1:]) for t in cause.ties],
        "is_prior_sensitive": cause.is_prior_sensitive,
    }


def _parameter_object(p: Parameter) -> dict[str, Any]:
    return {
        "effect": p.effect,
        "place": p.variant,
        "size": p.size,
        "low": p.low,
        "high": p.high,
        "unit": p.unit,
        "words": p.words,
    }


def _place_object(p: Place) -> dict[str, Any]:
    return {
        "name": p.name,
        "z": p.z,
        "p_value": p.p_value,
        "is_significant": p.is_significant,
        "share": p.share,
        "gap_microstrain": p.gap_microstrain,
    }


def _finite(value: Any) -> Any:
    if isinstance(value, dict):
        return {key: _finite(item) for key, item in value.items()}
    if isinstance(value, list):
        return [_finite(item) for item in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value
