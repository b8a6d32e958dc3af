"""Effects of two gauges: their wires exchanged, the signal of one leaking into the other.

A place such as ``a/b`` or ``a<b`` names the two, whatever the gauges are called.
"""

from collections.abc import Iterable
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from octmip.errors import DataError
from octmip.twin import Load, State, Twin, channels_of, units_of


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


@dataclass(frozen=True, slots=True)
class Crosstalk:
    """reading_a = strain_a + size / 100 strain_b for channels a, b next to each other."""

    name: str = "crosstalk"
    parameter: str = "part of the neighbouring channel's signal in one reading"
    unit: str = "%"
    prior_mean: float = 0.0
    prior_sd: float = 1.0
    prior_source: str = "multiplexers and common grounds leak up to one per cent"
    is_one_sided: bool = False
    separated_by: str = (
        "in one state it equals a gain of the gauge; "
        "states that change the neighbour's strain alone, or a shunt on the neighbour, separate them"
    )
    load_power: int | None = None
    words: str = "crosstalk between neighbouring channels"
    words_at: str = "crosstalk from gauge {second} into gauge {first}"
    action: str = "separate the channels of gauges {second} and {first}"
    says: tuple[str, str] = (
        "{size} of the signal of gauge {second} leaks into gauge {first}",
        "{size} of the signal of gauge {second} leaks into gauge {first} with its sign reversed",
    )
    seen_by: tuple[str, ...] = ("shunt_reading",)

    def places(self, twin: Twin) -> tuple[str, ...]:
        """Return the ordered pairs of neighbouring channels, reading first."""
        pairs = alike_pairs(twin, zip(twin.gauges, twin.gauges[1:], strict=False))
        return tuple(f"{a}<{b}" for a, b in [*pairs, *((b, a) for a, b in pairs)])

    def gauges_of(self, twin: Twin, place: str) -> tuple[str, ...]:
        """Return the two gauges of a place."""
        return tuple(twin.gauges[k] for k in pair_of(twin, place, "<"))

    def signature(
        self, twin: Twin, state: State, load_factor: Load, place: str = "", time: float = 0.0
    ) -> NDArray[np.float64]:
        """Return the change of the readings (n_gauges,) per unit of size."""
        change = np.zeros(len(twin.gauges))
        reading, source = pair_of(twin, place, "<")
        change[reading] = 0.01 * twin.predict(state, load_factor)[source]
        return change


@dataclass(frozen=True, slots=True)
class SwappedPair:
    """Readings a and b exchanged with size 1."""

    name: str = "swapped_pair"
    parameter: str = "1 when the two are exchanged"
    unit: str = "-"
    prior_mean: float = 1.0
    prior_sd: float = 0.02
    prior_source: str = "two channels are exchanged or they are not"
    is_one_sided: bool = True
    separated_by: str = "tapping or heating one gauge shows which channel answers"
    load_power: int | None = None
    words: str = "exchanged wires of two gauges"
    words_at: str = "exchanged wires of gauges {first} and {second}"
    action: str = "exchange the wires of gauges {first} and {second}"
    says: tuple[str, str] = ("each shows the strain of the other", "each shows the strain of the other")
    seen_by: tuple[str, ...] = ("channel_order",)
    acts_on_readings: bool = True

    def places(self, twin: Twin) -> tuple[str, ...]:
        """Return the pairs of gauges."""
        every = ((a, b) for k, a in enumerate(twin.gauges) for b in twin.gauges[k + 1 :])
        return tuple(f"{a}/{b}" for a, b in alike_pairs(twin, every))

    def gauges_of(self, twin: Twin, place: str) -> tuple[str, ...]:
        """Return the two gauges of a place."""
        return tuple(twin.gauges[k] for k in pair_of(twin, place, "/"))

    def signature(
        self, twin: Twin, state: State, load_factor: Load, place: str = "", time: float = 0.0
    ) -> NDArray[np.float64]:
        """Return the change of the readings (n_gauges,) per unit of size."""
        change = np.zeros(len(twin.gauges))
        first, second = pair_of(twin, place, "/")
        strain = twin.predict(state, load_factor)
        change[first] = strain[second] - strain[first]
        change[second] = -change[first]
        return change
