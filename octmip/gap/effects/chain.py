"""What a measuring chain does beyond the families: its formula needs an angle, a place, a second gauge or a load.

| effect | readings with size s, at its place |
|---|---|
| misalignment | (1 - (1 + nu) s / 100) r, s / 100 = sin^2(angle), shear left out, nu = 0.3 |
| position_offset | r + s dr/dy, the slope from the neighbouring gauges |
| dead_gauge | (1 - s) r with s = 1: zero and noise whatever the strain |
| crosstalk | r_a + s / 100 r_b for channels a, b next to each other; place ``a<b`` |
| swapped_pair | r_a and r_b exchanged with s = 1; place ``a/b`` |

Angle and place are asked of strain gauges alone. Where one instrument gives several readings
(`octmip.twin.channels_of`), its faults act on all of them, and it is never exchanged.
"""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import lru_cache, partial

import numpy as np
from numpy.typing import NDArray

from octmip.errors import DataError, TwinError
from octmip.twin import STRAINS, Load, State, Twin, channels_of, positions_of, units_of

Floats = NDArray[np.float64]

POISSON = 0.3
"""Transverse contraction that a turned gauge feels."""


@dataclass(frozen=True, slots=True, eq=False)
class Moment:
    """The twin at one state, load and time, and what an effect acts on there: gauges by number, or a load by name."""

    twin: Twin
    state: State
    load: Load
    places: tuple[str, ...] = ("",)
    time: float = 0.0
    gauges: tuple[tuple[int, ...], ...] = ()
    load_name: str = ""

    @property
    def readings(self) -> Floats:
        """(n_gauges,) of the twin."""
        return self.twin.predict(self.state, self.load)


@dataclass(frozen=True, slots=True, eq=False)
class ChainEffect:
    """An effect of the measuring chain as a formula.

    Attributes
    ----------
    change
        change of the readings (n_places, n_gauges) per unit of size.
    places_in
        where it may act in a twin.
    separator
        between the two gauges of a place; "" where a place is one instrument or the whole.
    load_name
        the load that is wrong, of a twin with several.
    is_nameless, commonness
        whether it is a cell of the families without a name of its own, and how probable it is beside other effects.

    The others are those of `octmip.twin.Effect`.
    """

    name: str
    parameter: str
    unit: str
    prior_sd: float
    separated_by: str
    change: Callable[[Moment], Floats]
    places_in: Callable[[Twin], tuple[str, ...]]
    separator: str = ""
    load_name: str = ""
    prior_mean: float = 0.0
    is_one_sided: bool = False
    load_power: int | None = None
    acts_on_readings: bool = False
    uses_time: bool = False
    is_nameless: bool = False
    commonness: float = 1.0
    seen_by: tuple[str, ...] = ()
    words: str = ""
    words_at: str = ""
    action: str = ""
    says: tuple[str, str] = ("", "")

    def places(self, twin: Twin) -> tuple[str, ...]:
        """Return where it may act."""
        return self.places_in(twin)

    def gauges_of(self, twin: Twin, place: str) -> tuple[str, ...]:
        """Return the gauges of a place."""
        return tuple(twin.gauges[k] for k in self._numbers(twin, place))

    def signature(self, twin: Twin, state: State, load_factor: Load, place: str = "", time: float = 0.0) -> Floats:
        """Return the change of the readings (n_gauges,) per unit of size."""
        return np.asarray(self.at_places(twin, state, load_factor, (place,), time)[0])

    def at_places(self, twin: Twin, state: State, load: Load, places: Sequence[str], time: float) -> Floats:
        """Return the signatures (n_places, n_gauges) at several places."""
        gauges = tuple(self._numbers(twin, place) for place in places)
        return self.change(Moment(twin, state, load, tuple(places), time, gauges, self.load_name))

    def _numbers(self, twin: Twin, place: str) -> tuple[int, ...]:
        if self.separator:
            return pair_of(twin.gauges, place, self.separator)
        return tuple(k for k, own in enumerate(channels_of(twin)) if own == place) if place else ()


@lru_cache(maxsize=65536)  # a diagnosis asks ten thousand times for each pair
def pair_of(gauges: tuple[str, ...], place: str, separator: str) -> tuple[int, int]:
    """Return the numbers of the two gauges of a place, which may have the separator in their own names.

    Raises
    ------
    DataError
        no two gauges of the twin, or several pairs, give the place.
    """
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


def _instruments(twin: Twin) -> tuple[str, ...]:
    return tuple(dict.fromkeys(channels_of(twin)))


def _strain_gauges(twin: Twin) -> tuple[str, ...]:
    found = zip(channels_of(twin), units_of(twin), strict=True)
    return tuple(dict.fromkeys(channel for channel, unit in found if unit in STRAINS))


def _placed_gauges(twin: Twin) -> tuple[str, ...]:
    return _strain_gauges(twin) if positions_of(twin) is not None else ()


def _alike(twin: Twin, pairs: Iterable[tuple[str, str]]) -> list[tuple[str, str]]:
    """Return the pairs of gauges that can be taken for each other: of one unit, each the one reading of its channel."""
    units, channels = dict(zip(twin.gauges, units_of(twin), strict=True)), channels_of(twin)
    several = {name for name, channel in zip(twin.gauges, channels, strict=True) if channels.count(channel) > 1}
    return [(a, b) for a, b in pairs if units[a] == units[b] and several.isdisjoint((a, b))]


def _neighbouring_channels(twin: Twin) -> tuple[str, ...]:
    pairs = _alike(twin, zip(twin.gauges, twin.gauges[1:], strict=False))
    return tuple(f"{a}<{b}" for a, b in [*pairs, *((b, a) for a, b in pairs)])


def _all_pairs(twin: Twin) -> tuple[str, ...]:
    every = ((a, b) for k, a in enumerate(twin.gauges) for b in twin.gauges[k + 1 :])
    return tuple(f"{a}/{b}" for a, b in _alike(twin, every))


def whole(twin: Twin) -> tuple[str, ...]:
    """Return the one place of an effect that acts on the whole."""
    return ("",)


def _of_gauges(formula: Callable[[Floats], Floats], moment: Moment) -> Floats:
    """Return what a formula of their readings changes at the gauges of each place (n_places, n_gauges)."""
    found, readings = np.zeros((len(moment.places), len(moment.twin.gauges))), moment.readings
    for row, gauges in zip(found, moment.gauges, strict=True):
        row[list(gauges)] = formula(readings[list(gauges)])
    return found


def _turned(own: Floats) -> Floats:
    return -0.01 * (1.0 + POISSON) * own


def _leaking(own: Floats) -> Floats:
    return np.array([0.01 * own[1], 0.0])


def _exchanged(own: Floats) -> Floats:
    return own[::-1] - own


def _offset(moment: Moment) -> Floats:
    positions, units = positions_of(moment.twin), units_of(moment.twin)
    if positions is None:
        raise TwinError(
            "the twin does not say where its gauges lie, so a gauge that lies elsewhere has no signature; expected "
            "gauge_positions (n_gauges, 2) [m]; give them"
        )
    found, readings = np.zeros((len(moment.places), len(moment.twin.gauges))), moment.readings
    for row, gauges in zip(found, moment.gauges, strict=True):
        for gauge in gauges:
            same = [k for k, unit in enumerate(units) if unit == units[gauge]]
            row[gauge] = 1e-3 * spanwise_slope(positions[same], readings[same], same.index(gauge))
    return found


def spanwise_slope(positions: Floats, strain: Floats, gauge: int) -> float:
    """Return d(strain)/dy [1/m] at one gauge: the best plane through it and its four nearest neighbours."""
    near = np.argsort(np.linalg.norm(positions - positions[gauge], axis=1), kind="stable")[1:5]
    offset = (positions[near] - positions[gauge])[:, :2]
    weight = 1.0 / np.linalg.norm(offset, axis=1)
    slope = np.linalg.lstsq(offset * weight[:, None], (strain[near] - strain[gauge]) * weight, rcond=None)[0]
    return float(slope[1])


MISALIGNMENT = ChainEffect(
    name="misalignment",
    parameter="sin^2 of the angle by which one gauge is turned (1 % is 5.7 degrees)",
    unit="%",
    prior_sd=1.0,  # gauges are laid to a few degrees; transverse sensitivity is of the same order
    separated_by="it only lowers a reading, a gain goes both ways; a shunt calibration sees a gain and not an angle",
    change=partial(_of_gauges, _turned),
    places_in=_strain_gauges,
    is_one_sided=True,
    seen_by=("gauge_placement",),
    words="angle of one gauge",
    action="check the angle of gauge {place}",
    says=("the squared sine of its error is {size}", "the squared sine of its error is {size}"),
)
POSITION_OFFSET = ChainEffect(
    name="position_offset",
    parameter="offset of one gauge outboard",
    unit="mm",
    prior_sd=3.0,  # gauges are placed to some millimetres
    separated_by="in one state it equals a gain of the gauge; measuring its place on the structure separates them",
    change=_offset,
    places_in=_placed_gauges,
    seen_by=("gauge_placement",),
    words="place of one gauge",
    action="measure the place of gauge {place}",
    says=("it sits {size} too far outboard", "it sits {size} too far inboard"),
)
DEAD_GAUGE = ChainEffect(
    name="dead_gauge",
    parameter="part of the signal that one gauge has lost",
    unit="-",
    prior_mean=1.0,
    prior_sd=0.02,  # a broken lead leaves nothing
    separated_by="the reading does not move with the load",
    change=partial(_of_gauges, np.negative),
    places_in=_instruments,
    is_one_sided=True,
    acts_on_readings=True,
    seen_by=("shunt_reading", "channel_order"),
    words="dead gauge",
    words_at="dead gauge {place}",
    action="repair gauge {place}",
    says=("it shows nothing of the strain", "it shows nothing of the strain"),
)
CROSSTALK = ChainEffect(
    name="crosstalk",
    parameter="part of the neighbouring channel's signal in one reading",
    unit="%",
    prior_sd=1.0,  # multiplexers and common grounds leak up to one per cent
    separated_by="in one state it equals a gain of the gauge; "
    "states that change the neighbour's strain alone, or a shunt on the neighbour, separate them",
    change=partial(_of_gauges, _leaking),
    places_in=_neighbouring_channels,
    separator="<",
    seen_by=("shunt_reading",),
    words="crosstalk between neighbouring channels",
    words_at="crosstalk from gauge {second} into gauge {first}",
    action="separate the channels of gauges {second} and {first}",
    says=(
        "{size} of the signal of gauge {second} leaks into gauge {first}",
        "{size} of the signal of gauge {second} leaks into gauge {first} with its sign reversed",
    ),
)
SWAPPED_PAIR = ChainEffect(
    name="swapped_pair",
    parameter="1 when the two are exchanged",
    unit="-",
    prior_mean=1.0,
    prior_sd=0.02,  # two channels are exchanged or they are not
    separated_by="tapping or heating one gauge shows which channel answers",
    change=partial(_of_gauges, _exchanged),
    places_in=_all_pairs,
    separator="/",
    is_one_sided=True,
    acts_on_readings=True,
    seen_by=("channel_order",),
    words="exchanged wires of two gauges",
    words_at="exchanged wires of gauges {first} and {second}",
    action="exchange the wires of gauges {first} and {second}",
    says=("each shows the strain of the other", "each shows the strain of the other"),
)


FORMULAS = (MISALIGNMENT, POSITION_OFFSET, SWAPPED_PAIR, DEAD_GAUGE, CROSSTALK)
"""Those that need no load's name."""
