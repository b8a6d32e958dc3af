"""Words for an effect: what a test engineer calls it, what to do about it, and what its size says.

An effect may bring these as plain attributes, which `octmip.twin.Effect` lists; in each, {place} is the place, {first}
and {second} are the two gauges of a pair. An effect without them is called by its name, underscores as spaces.
"""

import re
from collections.abc import Mapping
from dataclasses import dataclass

from octmip.gap.effects.simple import test_of
from octmip.twin import Effect, Twin


@dataclass(frozen=True, slots=True)
class EffectWords:
    """The words for one effect at one place.

    Attributes
    ----------
    name
        what it is, such as "gain of gauge g05".
    action
        what to do about it, such as "recalibrate gauge g05".
    above, below
        what a positive and a negative size say, {size} for the size without its sign; "" where the effect has no
        words, or where it has no size to speak of.
    has_size
        whether the size is worth a number: two wires are exchanged or they are not.
    """

    name: str
    action: str
    above: str
    below: str
    has_size: bool


def effect_words(effect: Effect) -> str:
    """Return what an effect is called wherever it acts."""
    return str(getattr(effect, "words", "")) or effect.name.replace("_", " ")


def placed(called: str) -> str:
    """Return what an effect is called at a place: one gauge or channel is then that of the place."""
    return called.replace("one gauge", "gauge {place}").replace("one channel", "{place}")


def words_at(effect: Effect, twin: Twin, place: str) -> EffectWords:
    """Return the words for an effect at a place."""
    called = effect_words(effect)
    there = placed(called)
    of_test = bool(test_of(effect, place))
    named = there if there != called or not place else f"{called} {'in' if of_test else 'at'} {{place}}"
    given = str(getattr(effect, "words_at", "")) or named
    names = _names(effect, twin, place)
    name = _filled(given, names)
    action = str(getattr(effect, "action", ""))
    above, below = getattr(effect, "says", ("", ""))
    return EffectWords(
        name=name,
        action=_filled(f"{action} in {{place}}" if of_test else action, names) if action else f"add {name} to the twin",
        above=_filled(above, names),
        below=_filled(below, names),
        has_size=not above or "{size}" in above,
    )


def _names(effect: Effect, twin: Twin, place: str) -> Mapping[str, str]:
    """Return what stands for the place and, where it names two gauges, for each of them."""
    own = getattr(effect, "gauges_of", None)
    gauges = tuple(own(twin, place)) if own is not None and place else ()
    pair = {"first": gauges[0], "second": gauges[1]} if len(gauges) == 2 else {}
    return {"place": place, **pair}


def _filled(template: str, names: Mapping[str, str]) -> str:
    """Return a template with the names filled in, each once: a brace within a name is only a brace."""
    return re.sub(r"\{(\w+)\}", lambda found: names.get(found[1], found[0]), template)
