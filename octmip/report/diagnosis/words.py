"""The diagnosis as a page of words for a test engineer."""

import math
import textwrap
from collections.abc import Sequence

from octmip.formats.names import visible_lines
from octmip.gap.causes import MISFIT, UNKNOWN, Cause
from octmip.gap.diagnosis import Diagnosis
from octmip.gap.location import Flip, Place
from octmip.gap.shrinkage import Shrinkage
from octmip.gap.sizes import Parameter

FEW = 5
"""Places of one kind that a page lists."""
LEAST_FLIP = 0.001
"""Share of the readings that a node must flip to be listed."""
WIDTH = 118
"""Characters in a line of the page."""


def page_of_words(diagnosis: Diagnosis) -> str:
    """Return the page: the verdict first, then where, which, how far, what next, noise, notes."""
    parts = [
        verdict(diagnosis),
        _section("Where", where_lines(diagnosis)),
        _section("Which", _which(diagnosis)),
        _section("How far", _how_far(diagnosis)),
        _section("Next test", _next(diagnosis)),
        _section("Noise", _noise(diagnosis)),
    ]
    if diagnosis.states:
        parts.append(_section("Unknown states", _state_lines(diagnosis)))
    if diagnosis.notes:
        parts.append(_section("Notes", list(diagnosis.notes)))
    return visible_lines("\n\n".join(parts))


def verdict(diagnosis: Diagnosis) -> str:
    """Return the answer in a sentence, and one more where gauges are clipped."""
    clipped = ", ".join(diagnosis.noise.clipped)
    return _answer(diagnosis) + (f" Clipped: {clipped}." if clipped else "")


def _answer(diagnosis: Diagnosis) -> str:
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
        return "no effect"
    if UNKNOWN in cause.effects:
        known = " and ".join(size_words(parameter) for parameter in cause.parameters)
        return f"something outside the library{f' beside {known}' if known else ''}"
    if not cause.is_identifiable:
        return f"some effect too small to name in these readings ({' + '.join(cause.effects)} or another)"
    shown = []
    for parameter in cause.parameters:
        found = next((c for c in cause.confounded if c.effects[0] == parameter.effect), None)
        shown.append(size_words(parameter, found.effects[1:] if found else ()))
    return " and ".join(shown)


def size_words(parameter: Parameter, others: Sequence[str] = ()) -> str:
    """Return an effect, `others` that cannot be told from it, its place, size and 90 % interval."""
    names = f"{parameter.effect} (or {' or '.join(dict.fromkeys(others))})" if others else parameter.effect
    place = f" at {parameter.place}" if parameter.place else ""
    interval = f"{parameter.low:.3g} to {parameter.high:.3g}"
    return f"{names}{place}: {with_unit(parameter.size, parameter.unit)} (90 % {interval})"


def with_unit(size: float, unit: str) -> str:
    """Return a number with its unit; "-" is the unit of a pure number."""
    return f"{size:.3g}" if unit == "-" else f"{size:.3g} {unit}"


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
    wrapped = [textwrap.fill(line, WIDTH, initial_indent="  ", subsequent_indent=_hang(line)) for line in lines]
    return "\n".join([title, *wrapped])


def _hang(line: str) -> str:
    return " " * (6 + len(line) - len(line.lstrip()))


def where_lines(diagnosis: Diagnosis) -> list[str]:
    """Return the whole gap, its greatest parts and the tree nodes that flip, a sentence each."""
    where = diagnosis.where
    significant = [entry for entry in where.entries if entry.is_significant]
    lines = [
        f"Gap of {where.rms_microstrain:.1f} microstrain root mean square beyond noise; {len(significant)} of "
        f"{len(where.entries)} mean readings differ significantly (false-discovery rate 5 %); p-value of no gap "
        f"{_chance(where.p_value)}."
    ]
    for kind, places in (("gauge", where.gauges), ("load", where.loads), ("test", where.tests)):
        worth = [place for place in places if place.is_significant]
        if worth and len(places) > 1:
            more = f"; and {len(worth) - FEW} more" if len(worth) > FEW else ""
            lines.append(f"By {kind}: {'; '.join(_place(place) for place in worth[:FEW])}{more}.")
    flipping = flipping_nodes(diagnosis)
    if where.nodes and not flipping:
        lines.append("At every node of the tree readings of the asset go the same way as the twin's.")
    for flip in flipping[:FEW]:
        lines.append(
            f"Tree node {flip.path or 'root'} ({flip.words}): {percent(flip.share)} of all readings go the other way "
            f"(left {percent(flip.simulated)} in the twin, {percent(flip.real)} in the asset)."
        )
    return lines


def flipping_nodes(diagnosis: Diagnosis) -> list[Flip]:
    """Return the tree's nodes at which a reading in a thousand or more goes the other way."""
    return [flip for flip in diagnosis.where.nodes if flip.share >= LEAST_FLIP]


def _chance(p_value: float) -> str:
    return f"{p_value:.2g}" if p_value > 1e-300 else "below 1e-300"


def _place(place: Place) -> str:
    return f"{place.name} {place.gap_microstrain:+.1f} microstrain, {percent(max(0.0, place.share))} of the gap"


def _which(diagnosis: Diagnosis) -> list[str]:
    first = diagnosis.which[0]
    lines: list[str] = []
    for cause in diagnosis.which[:FEW]:
        if cause is not first and (cause.probability < 0.005 or UNKNOWN in cause.effects):
            continue  # the unknown has a line of its own below
        lines.append(f"{likely(cause.probability):>12}  {cause_words(cause)}")
        if cause is first and UNKNOWN not in cause.effects:
            lines += _explained(cause)
    if first.is_prior_sensitive:
        lines.append(
            "Prior-sensitive: another cause would lead if all prior scales were three times smaller or larger."
        )
    lines.append(f"Something outside the library: {likely(diagnosis.unknown_probability)}.")
    if diagnosis.is_sound:
        lines.append(f"With 95 % power these readings would have shown: {_limits(diagnosis)}.")
    lines += [f"No statement on {name}: {reason}." for name, reason in list(diagnosis.refused.items())[:FEW]]
    return lines


def _explained(cause: Cause) -> list[str]:
    """Return what the effects of a cause mean and what cannot be told from them, a line each."""
    indent = " " * 14
    shown = cause.parameters if cause.is_identifiable else ()
    meant = [f"{indent}{effect}: {words}" for effect, words in {p.effect: p.words for p in shown}.items()]
    return meant + [f"{indent}cannot be told apart: {' / '.join(c.effects)}: {c.reason}" for c in cause.confounded]


def _limits(diagnosis: Diagnosis) -> str:
    candidates = diagnosis.posterior.model.inputs.candidates
    units = {c.name: c.effect.unit for c in candidates if not c.is_discrete}
    shown = [(n, s) for n, s in diagnosis.detectable.items() if n in units and n not in diagnosis.refused]
    return ", ".join(f"{name} {with_unit(float(f'{size:.2g}'), units[name])}" for name, size in shown)


def _how_far(diagnosis: Diagnosis) -> list[str]:
    s = diagnosis.shrinkage
    if s is None:
        return ["No effect was added, so the gap does not close."]
    lines = [
        closed_words(s),
        f"Chi-squared per reading {s.chi2_before:.2f} -> {s.chi2_after:.2f} (p-value of what remains "
        f"{_chance(s.p_after)}).",
    ]
    if s.p_after < MISFIT:
        lines.append("Something that no cause of the library describes remains in the readings.")
    lines += [f"{h.name} held out: {h.before:.1f} -> {h.after:.1f} microstrain" for h in s.held_out]
    return lines


def closed_words(s: Shrinkage) -> str:
    """Return how far the first cause of the library closes the gap on held-out readings, as a sentence."""
    if not s.held_out:
        return (
            "With one load and one test nothing can be held out: repeat the test at another load to see the gap close."
        )
    gap = f"Held-out gap {s.before:.1f} -> {s.after:.1f} microstrain (two good models differ by {s.floor:.1f})"
    if math.isnan(s.closed):
        return f"{gap}: too small beside the noise for a share to mean anything."
    if abs(s.closed) < 0.01 and s.chi2_after < 0.5 * s.chi2_before:
        return f"{gap}: the effect shows at one load or in one test only; the others say nothing about its size there."
    interval = f"90 % interval {percent(s.low)} to {percent(s.high)}"
    if s.closed >= 1.0:
        return f"{gap}: the gap closed as far as it can ({percent(s.closed)} of its square; {interval})."
    return f"{gap}: {percent(s.closed)} of the squared gap closed ({interval})."


def _next(diagnosis: Diagnosis) -> list[str]:
    if not diagnosis.next_test:
        return ["Little uncertainty remains among the effects of the library; no further test is needed."]
    lines = [
        f"{p.words} ({p.name}): about {p.information / math.log(2):.2f} bits at cost {p.cost:g}"
        for p in diagnosis.next_test[:4]
    ]
    if not any(p.is_strain_test for p in diagnosis.next_test):
        lines.append("No strain test helps: the effects in question change all strains in the same way.")
    return lines


def _noise(diagnosis: Diagnosis) -> list[str]:
    noise = diagnosis.noise
    lines = [
        f"Standard deviation of one reading {noise.sd_microstrain:.1f} microstrain (typical gauge; variance "
        f"{noise.sd_microstrain**2:.0f}); lag-1 correlation {noise.lag1:.2f}, excess kurtosis {noise.kurtosis:.2f}, "
        f"step {noise.step:g} microstrain."
    ]
    if noise.inflation > 1.0:
        lines.append(
            f"Successive readings are correlated: the variance of a mean is {noise.inflation:.1f} times as large."
        )
    if noise.findings:
        lines.append(f"Not white noise: {', '.join(noise.findings)}.")
    return lines


def _state_lines(diagnosis: Diagnosis) -> list[str]:
    return [
        f"{', '.join(s.tests)}: " + ", ".join(f"{n} {s.mean[n]:.3f} +- {s.sd[n]:.3f}" for n in s.mean)
        for s in diagnosis.states
    ]
