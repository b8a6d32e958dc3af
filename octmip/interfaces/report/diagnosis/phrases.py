"""Parts of sentences about a diagnosis: shares, sizes with intervals, causes, how far the gap closes."""

import math
from collections.abc import Sequence

from octmip.gap.causes import UNKNOWN, Cause
from octmip.gap.diagnosis import Diagnosis
from octmip.gap.effects.words import effect_words
from octmip.gap.shrinkage import Shrinkage
from octmip.gap.sizes import Parameter
from octmip.twin import MICROSTRAIN, MIXED, PURE

OUTSIDE = "something outside the library"
FINDINGS = {
    "heavy_tailed_noise": "more far-off readings than a normal distribution has",
    "heteroscedastic_noise": "noise that differs between gauges or loads",
    "correlated_noise": "noise that successive readings or several gauges share",
    "quantisation": "readings in coarse steps",
    "random_walk": "noise that wanders from test to test",
    "clipping": "readings cut off at the end of a range",
    "stuck_channel": "a channel that stands still",
    "jump": "a gauge that jumps",
    "outliers": "far-off readings to one side",
}
"""What is found in the noise, in words."""


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


def about(probability: float) -> str:
    """Return a probability in whole per cent where that is no certainty."""
    return f"{100 * probability:.0f} %" if 0.01 <= probability < 0.99 else likely(probability)


def listed(names: Sequence[str], last: str = "and") -> str:
    """Return names as a list in a sentence: a, b and c."""
    return names[0] if len(names) == 1 else f"{', '.join(names[:-1])} {last} {names[-1]}"


def with_unit(size: str, unit: str) -> str:
    """Return a number with its unit; a pure number has none."""
    return size if unit in PURE else f"{size} {unit}"


def amount(value: float, unit: str, plus: str = "") -> str:
    """Return a reading or a difference of readings with its unit: tenths of a microstrain, else three digits."""
    return with_unit(digits_of(value, unit, plus), unit)


def digits_of(value: float, unit: str, plus: str = "") -> str:
    """Return the digits of a reading: tenths of a microstrain and of a noise, else four significant ones."""
    return f"{value:{plus}.1f}" if unit in (MICROSTRAIN, MIXED) else f"{value:{plus}.4g}"


def units_words(diagnosis: Diagnosis) -> str:
    """Return what the readings are in: their unit, or that each has its own."""
    units = set(diagnosis.posterior.model.inputs.units)
    return f"in {units.pop()}" if len(units) == 1 else "each in its unit"


def decimals(low: float, high: float) -> int:
    """Return the decimals with which an interval shows two digits of its width."""
    width = high - low
    return min(6, max(0, 1 - math.floor(math.log10(width)))) if width > 0.0 else 2


def interval_words(parameter: Parameter, sign: float = 1.0) -> str:
    """Return the 90 % interval of a size times `sign`."""
    digits = decimals(parameter.low, parameter.high)
    low, high = sorted((sign * parameter.low, sign * parameter.high))
    return "90 %: " + with_unit(f"{_plain(low, digits)} to {_plain(high, digits)}", parameter.unit)


def size_of(parameter: Parameter, sign: float = 1.0) -> str:
    """Return the size times `sign`, with its unit, to the digits that its interval bears."""
    digits = decimals(parameter.low, parameter.high)
    return with_unit(_plain(sign * parameter.size, digits), parameter.unit)


def _plain(value: float, digits: int) -> str:
    shown = f"{value:.{digits}f}"
    return shown.lstrip("-") if float(shown) == 0.0 else shown


def size_words(parameter: Parameter) -> str:
    """Return what an effect is called at its place, with size and interval where it has a size."""
    if not parameter.named.has_size:
        return parameter.named.name
    return f"{parameter.named.name}: {size_of(parameter)} ({interval_words(parameter)})"


def brief_words(parameter: Parameter) -> str:
    """Return what an effect is called at its place, with size and interval in brackets where it has a size."""
    if not parameter.named.has_size:
        return parameter.named.name
    return f"{parameter.named.name} ({size_of(parameter)}; {interval_words(parameter)})"


def finding_words(parameter: Parameter) -> str:
    """Return what the size of an effect says, with its interval: "it reads 4.1 % too high (90 %: 3.2 to 5.0 %)"."""
    named = parameter.named
    template = named.above if parameter.size >= 0.0 else named.below
    if not template:
        return f"{parameter.words} {size_of(parameter)} ({interval_words(parameter)})"
    if not named.has_size:
        return template
    sign = 1.0 if parameter.size >= 0.0 else -1.0
    return f"{template.replace('{size}', size_of(parameter, sign))} ({interval_words(parameter, sign)})"


def cause_words(cause: Cause) -> str:
    """Return the effects of a cause with size and interval, and what cannot be told from them."""
    if not cause.effects:
        return "no effect"
    if UNKNOWN in cause.effects:
        known = " and ".join(size_words(parameter) for parameter in cause.parameters)
        return f"{OUTSIDE}{f' beside {known}' if known else ''}"
    if not cause.is_identifiable:
        return f"an effect too small to name in these readings ({listed(effect_names(cause))}, or another)"
    return "; and ".join(_with_others(cause, parameter) for parameter in cause.parameters)


def effect_names(cause: Cause) -> list[str]:
    """Return what the effects of a cause are called, wherever they act."""
    called = {c.name: effect_words(c.effect) for c in cause.judged.model.inputs.candidates}
    return [called.get(name, OUTSIDE) for name in cause.effects]


def cause_names(cause: Cause) -> str:
    """Return what the effects of a cause are called at their places, without their sizes."""
    if not cause.effects:
        return "no effect"
    if UNKNOWN in cause.effects or not cause.is_identifiable:
        return cause_words(cause)
    return " with ".join(parameter.named.name for parameter in cause.parameters)


def _with_others(cause: Cause, parameter: Parameter) -> str:
    own = (parameter.effect, parameter.place)
    found = next((c for c in cause.confounded if (c.effects[0], c.places[0]) == own), None)
    others = f", or {listed(list(dict.fromkeys(found.words[1:])), 'or')}" if found else ""
    return size_words(parameter) + others


def closed_words(s: Shrinkage) -> str:
    """Return how far the first cause of the library closes the gap on held-out readings, in a sentence or two."""
    if not s.held_out:
        return (
            "With one load and one test nothing can be held out: repeat the test at another load to see the gap close."
        )
    gap = (
        f"On readings to which nothing was fitted the gap goes from {digits_of(s.before, s.unit)} to "
        f"{amount(s.after, s.unit)}; a sound asset and its twin differ by {digits_of(s.floor, s.unit)}."
    )
    if math.isnan(s.closed):
        return f"{gap} The gap is too small beside the noise to say which share of it closed."
    if abs(s.closed) < 0.01 and s.chi2_after < 0.5 * s.chi2_before:
        return (
            f"{gap} The effect shows at one load or in one test only: the others say nothing about its size there, so "
            "no gap closes."
        )
    if s.closed >= 1.0:
        return f"{gap} So all of the gap has closed: the rest is no more than a sound asset may differ by."
    most = "all of it" if s.high >= 1.0 else percent(s.high)
    least = "none of it" if s.low <= 0.0 else percent(s.low)
    if s.closed <= 0.0:
        return f"{gap} None of the gap has closed."
    return f"{gap} So {percent(s.closed)} of its mean square has closed (90 %: {least} to {most})."


def effect_called(diagnosis: Diagnosis, name: str) -> str:
    """Return what an effect of the library is called, by its name."""
    candidates = diagnosis.posterior.model.inputs.candidates
    return next((effect_words(c.effect) for c in candidates if c.name == name), name.replace("_", " "))
