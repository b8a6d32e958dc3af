"""The diagnosis as a page of words for a test engineer."""

import math
import textwrap
from collections.abc import Sequence

from octmip.gap.causes import MISFIT, UNKNOWN, Cause, ConfoundedEffects
from octmip.gap.diagnosis import Diagnosis
from octmip.gap.location import Flip, Place
from octmip.gap.sizes import Parameter
from octmip.input.names import shown, visible_lines
from octmip.interfaces.report.diagnosis.measured import noise_sds
from octmip.interfaces.report.diagnosis.phrases import (
    FINDINGS,
    OUTSIDE,
    amount,
    cause_words,
    closed_words,
    decimals,
    digits_of,
    effect_called,
    likely,
    listed,
    percent,
    with_unit,
)
from octmip.interfaces.report.diagnosis.recommendation import recommend
from octmip.twin import PURE

FEW = 5
"""Places of one kind that a page lists."""
LEAST_FLIP = 0.001
"""Share of the readings that a node must flip to be listed."""
NO_SUCH_TEST = "No test with these gauges alone helps: the effects in question change all readings in the same way."
"""Where every test that is worth running needs another instrument."""
WIDTH = 118
"""Characters in a line of the page."""


def page_of_words(diagnosis: Diagnosis) -> str:
    """Return the page: what to do first, then where, which, how far, what next, noise, notes."""
    parts = [
        textwrap.fill(recommend(diagnosis), WIDTH),
        _section("Where the gap lies", where_lines(diagnosis)),
        _section("Which effect explains it", _which(diagnosis)),
        _section("How far the gap closes", _how_far(diagnosis)),
        _section("Which test to run next", next_lines(diagnosis)),
        _section("Noise of the readings", noise_lines(diagnosis)),
    ]
    if diagnosis.states:
        parts.append(_section("Unknown states of the asset", state_lines(diagnosis)))
    if diagnosis.constants:
        parts.append(_section("Constants of the asset", constant_lines(diagnosis)))
    if diagnosis.notes:
        parts.append(_section("Notes on the data", list(diagnosis.notes)))
    return visible_lines("\n\n".join(parts))


def constant_lines(diagnosis: Diagnosis) -> list[str]:
    """Return what the readings say of each constant that no run tells, beside the drawing's."""
    lines = []
    for one in diagnosis.constants:
        low, high = one.interval
        digits = decimals(low, high)
        most = max(one.correlation, key=lambda name: abs(one.correlation[name]), default="")
        beside = f"; correlation with {most} {one.correlation[most]:.2f}" if most else ""
        value = with_unit(f"{one.mean:.{digits}f}", one.unit)
        lines.append(
            f"{one.name.replace('_', ' ')}: {value} (90 %: {low:.{digits}f} to {high:.{digits}f}), drawn as "
            f"{one.drawn:g}{beside}."
        )
    return lines


def _section(title: str, lines: Sequence[str]) -> str:
    wrapped = [textwrap.fill(line, WIDTH, initial_indent="  ", subsequent_indent=_hang(line)) for line in lines]
    return "\n".join([title, *wrapped])


def _hang(line: str) -> str:
    return " " * (6 + len(line) - len(line.lstrip()))


def where_lines(diagnosis: Diagnosis) -> list[str]:
    """Return the whole gap, its greatest parts and the tree nodes that flip, a sentence each."""
    return [gap_line(diagnosis), *place_lines(diagnosis), *_node_lines(diagnosis)]


def gap_line(diagnosis: Diagnosis) -> str:
    """Return how large the whole gap is."""
    where = diagnosis.where
    significant = sum(entry.is_significant for entry in where.entries)
    return (
        f"Readings and twin differ by {amount(where.rms, where.unit)} root mean square beyond the noise; "
        f"{significant} of {len(where.entries)} mean readings differ significantly (false-discovery rate 5 %; p-value "
        f"of no gap {_chance(where.p_value)})."
    )


def place_lines(diagnosis: Diagnosis) -> list[str]:
    """Return the gauges, loads and tests that carry the gap, a line for each kind."""
    where, lines = diagnosis.where, []
    for kind, places in (("gauge", where.gauges), ("load", where.loads), ("test", where.tests)):
        worth = [place for place in places if place.is_significant]
        if worth and len(places) > 1:
            more = f"; and {len(worth) - FEW} more" if len(worth) > FEW else ""
            lines.append(f"By {kind}: {'; '.join(_place(place) for place in worth[:FEW])}{more}.")
    return lines + seat_lines(diagnosis)


def named_gauges(diagnosis: Diagnosis) -> list[str]:
    """Return the gauges that the first cause names."""
    gauges = diagnosis.posterior.model.inputs.campaign.gauges
    return [one.place for one in diagnosis.which[0].parameters if one.place in gauges]


def seat_lines(diagnosis: Diagnosis) -> list[str]:
    """Return where the gauges of the first cause sit, a sentence each; none where the twin does not say."""
    inputs = diagnosis.posterior.model.inputs
    places = inputs.twin.gauge_positions
    if places is None:
        return []
    seats = {name: places[inputs.twin.gauges.index(name)] for name in named_gauges(diagnosis)}
    return [f"{shown(name)} sits at x {x:.4g} m, y {y:.4g} m." for name, (x, y, *_) in seats.items()]


def _node_lines(diagnosis: Diagnosis) -> list[str]:
    flipping = flipping_nodes(diagnosis)
    if diagnosis.where.nodes and not flipping:
        return ["At every node of the tree readings of the asset go the same way as the twin's."]
    return [
        f"Tree node {node_name(flip)} ({flip.words}): {percent(flip.share)} of all readings go the other way "
        f"(left {percent(flip.simulated)} in the twin, {percent(flip.real)} in the asset)."
        for flip in flipping[:FEW]
    ]


def node_name(flip: Flip) -> str:
    """Return the way to a node from the root, in words."""
    return ", ".join({"L": "left", "R": "right"}[turn] for turn in flip.path) or "root"


def flipping_nodes(diagnosis: Diagnosis) -> list[Flip]:
    """Return the tree's nodes at which a reading in a thousand or more goes the other way."""
    return [flip for flip in diagnosis.where.nodes if flip.share >= LEAST_FLIP]


def _chance(p_value: float) -> str:
    return f"{p_value:.2g}" if p_value > 1e-12 else "below 1e-12"


def _place(place: Place) -> str:
    return f"{place.name} {amount(place.gap, place.unit, '+')}, {percent(max(0.0, place.share))} of the gap"


def _which(diagnosis: Diagnosis) -> list[str]:
    first = diagnosis.which[0]
    lines: list[str] = []
    for cause in shown_causes(diagnosis):
        lines.append(f"{likely(cause.probability):>12}  {cause_words(cause)}")
        if cause is first and UNKNOWN not in cause.effects:
            lines += [f"{' ' * 14}{line}" for line in explained(cause)]
    return [*lines, *doubt_lines(diagnosis)]


def shown_causes(diagnosis: Diagnosis) -> list[Cause]:
    """Return the causes that are listed; the unknown has a line of its own unless it leads."""
    first, *others = diagnosis.which[:FEW]
    return [first, *(c for c in others if c.probability >= 0.005 and UNKNOWN not in c.effects)]


def doubt_lines(diagnosis: Diagnosis) -> list[str]:
    """Return how sure the list of causes is, and what these readings could not have shown, a line each."""
    lines = []
    if UNKNOWN in diagnosis.which[0].effects:
        lines.append(f"It looks like {diagnosis.posterior.unknown_words}.")
    else:
        lines.append(f"{OUTSIDE.capitalize()}: {likely(diagnosis.unknown_probability)}.")
    if not diagnosis.which[0].effects:
        sizes = ", ".join(f"{name} {size}" for name, size in detectable_sizes(diagnosis))
        lines.append(f"Detectable sizes (these readings would have shown them with 95 % power): {sizes}.")
    for group in diagnosis.ties[:FEW]:
        called = listed([effect_called(diagnosis, name) for name in group])
        lines.append(f"The twin sees one and the same change in {called}: these readings can never tell them apart.")
    refused = list(diagnosis.refused.items())[:FEW]
    return lines + [f"No statement on {effect_called(diagnosis, name)}: {reason}." for name, reason in refused]


def explained(cause: Cause) -> list[str]:
    """Return what the effects of a cause mean and what cannot be told from them, a line each."""
    shown = cause.parameters if cause.is_identifiable else ()
    meant = [_meant(p) for p in {p.effect: p for p in shown}.values() if p.named.has_size]
    return meant + [line for found in cause.confounded for line in confounded_lines(found)]


def _meant(parameter: Parameter) -> str:
    unit = "" if parameter.unit in PURE else f", in {parameter.unit}"
    return f"Size of the {parameter.named.name}{unit}: {parameter.words}."


def confounded_lines(found: ConfoundedEffects) -> list[str]:
    """Return which effects cannot be told apart, why, and what would separate each from the others."""
    separated = zip(found.words, found.separated_by, strict=False)
    alike = listed(list(found.words))
    return [f"Cannot be told apart: {alike}; {found.reason}.", *(f"{name}: {how}." for name, how in separated)]


def detectable_sizes(diagnosis: Diagnosis) -> list[tuple[str, str]]:
    """Return what each effect is called, with the size from which it would have been seen with 95 % power."""
    candidates = diagnosis.posterior.model.inputs.candidates
    units = {c.name: c.effect.unit for c in candidates if not c.is_discrete}
    seen = [(n, s) for n, s in diagnosis.detectable.items() if n in units and n not in diagnosis.refused]
    return [(effect_called(diagnosis, n), with_unit(f"{float(f'{s:.2g}'):.10g}", units[n])) for n, s in seen]


def _how_far(diagnosis: Diagnosis) -> list[str]:
    s = diagnosis.shrinkage
    if s is None:
        return ["No effect was added, so the gap does not close."]
    held = [
        f"{h.name} predicted from the others: {digits_of(h.before, s.unit)} -> {amount(h.after, s.unit)}"
        for h in s.held_out
    ]
    return [closed_words(s), *fit_lines(diagnosis), *held]


def fit_lines(diagnosis: Diagnosis) -> list[str]:
    """Return how well the first cause of the library fits all readings, a sentence each."""
    s = diagnosis.shrinkage
    if s is None:
        return []
    fit = (
        f"Chi-squared per mean reading: {s.chi2_before:.2f} before, {s.chi2_after:.2f} after (p-value of the rest "
        f"{_chance(s.p_after)})."
    )
    left = "Something remains in the readings that no cause of the library describes."
    return [fit, left] if s.p_after < MISFIT else [fit]


def next_lines(diagnosis: Diagnosis) -> list[str]:
    """Return the tests that are worth running, a line each."""
    if not diagnosis.next_test:
        return ["Little uncertainty remains among the effects of the library; no further test is needed."]
    lines = [
        f"{p.words}: about {p.information / math.log(2):.2f} bits at cost {p.cost:g} (1 is a test at a load that was "
        "applied before)"
        for p in diagnosis.next_test[:4]
    ]
    return [*lines, NO_SUCH_TEST] if not any(p.is_strain_test for p in diagnosis.next_test) else lines


def noise_lines(diagnosis: Diagnosis) -> list[str]:
    """Return what the repeats say of the noise, a sentence each."""
    noise, sds = diagnosis.noise, noise_sds(diagnosis)
    sd = listed([amount(value, unit) for unit, value in sds.items()])
    step = f", step {with_unit(f'{noise.step:g}', next(iter(sds)))}" if len(sds) == 1 else ""
    lines = [
        f"Standard deviation of one reading {sd} (typical gauge); lag-1 correlation {noise.lag1:.2f}, excess kurtosis "
        f"{noise.kurtosis:.2f}{step}."
    ]
    if noise.remembers:
        lines.append(
            f"Successive readings are correlated: the variance of a mean is {noise.inflation:.1f} times as large."
        )
    if noise.walk_sd > 0.0:
        lines.append(f"The readings wander{_walk_words(diagnosis)}. Read the loads in turns, or zero the gauges often.")
    if noise.findings:
        found = ", ".join(FINDINGS.get(name, name.replace("_", " ")) for name in noise.findings)
        lines.append(f"Not plain white noise: {found}.")
    return lines


def _walk_words(diagnosis: Diagnosis) -> str:
    """Return how far the readings of the typical gauge wander over the campaign, where all have one unit."""
    inputs = diagnosis.posterior.model.inputs
    if len(set(inputs.units)) > 1:
        return " over the campaign"
    steps = max(float(average.moments.max()) for average in inputs.averages)
    over = diagnosis.noise.walk_sd * math.sqrt(steps)
    return f": the typical gauge by {amount(over, inputs.unit)} over the campaign (one standard deviation)"


def state_lines(diagnosis: Diagnosis) -> list[str]:
    """Return the unknown states as the first cause leaves them, a line for each."""
    return [
        f"{', '.join(s.tests)}: " + ", ".join(f"{n} {s.mean[n]:.3f} +- {s.sd[n]:.3f}" for n in s.mean)
        for s in diagnosis.states
    ]
