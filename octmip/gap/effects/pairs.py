"""The two gauges that a place such as ``a/b`` names, whatever the gauges are called."""

from collections.abc import Iterable
from functools import lru_cache

from octmip.errors import DataError
from octmip.twin import Twin, channels_of, units_of


def alike_pairs(twin: Twin, pairs: Iterable[tuple[str, str]]) -> list[tuple[str, str]]:
    """Return the pairs of gauges that can be taken for each other: of one unit, each the one reading of its channel."""
    units, channels = dict(zip(twin.gauges, units_of(twin), strict=True)), channels_of(twin)
    several = {name for name, channel in zip(twin.gauges, channels, strict=True) if channels.count(channel) > 1}
    return [(a, b) for a, b in pairs if units[a] == units[b] and several.isdisjoint((a, b))]


def pair_of(twin: Twin, place: str, separator: str) -> tuple[int, int]:
    """Return the numbers of the two gauges of a place, which may have the separator in their own names.

    Raises
    ------
    DataError
        no two gauges of the twin, or several pairs, give the place.
    """
    return _pair(twin.gauges, place, separator)


@lru_cache(maxsize=65536)  # a diagnosis asks ten thousand times for each pair
def _pair(gauges: tuple[str, ...], place: str, separator: str) -> tuple[int, int]:
    number = {name: k for k, name in enumerate(gauges)}
    cuts = [k for k, letter in enumerate(place) if letter == separator]
    named = [(place[:k], place[k + 1 :]) for k in cuts]
    pairs = [(number[a], number[b]) for a, b in named if a in number and b in number]
    if len(pairs) != 1:
        raise DataError(
            f"the place {place!r} names {len(pairs)} pairs of gauges of the twin; expected two of its "
            f"{len(number)} gauges with {separator!r} between them in one way only; correct it or rename a gauge"
        )
    return pairs[0]
