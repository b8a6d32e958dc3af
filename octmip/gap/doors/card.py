"""The card of a model behind a door: its readings with units, its loads, and the range of every parameter.

As a file it is one JSON object; only "readings" is needed:

    {"readings": {"f1": "Hz", "u_top": "mm"}, "loads": ["force"], "states": ["crack"],
     "parameters": {"stiffness": [100, 80, 120, "kN/m"]}, "sign": "...", "channels": {"f1": "accelerometer"}}

A parameter's range is its nominal value, the least and the greatest value that the asset may have, and the unit.
"states" are parameters whose values a campaign gives test by test (a damage of 0.2, a fraction); a state that a
campaign leaves out is 0. "state_limits" says up to which value each state is looked for where it is unknown:
{"crack": 0.6}. The search asks the model some hundred times, so a state without a limit is taken as stated. Functions
and tables are fast: their states are looked for without being asked, up to 1 and up to the table's greatest value.
"linear": true says that readings are proportional to the loads: one question then answers all their multiples.
"positions" says where each reading is taken, {"f1": [1.5, 0.0]} in metres: the page then shows the place.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from numbers import Real
from pathlib import Path
from typing import Any

from octmip.errors import DataError
from octmip.input.checked import Either, Kind, ListOf, MapOf, Number, Record, Text, Truth
from octmip.input.files import read_json_object
from octmip.input.messages import shown
from octmip.twin import ONE_LOAD

ENTRIES: dict[str, Kind] = {
    "readings": MapOf(Text()),
    "loads": ListOf(Text()),
    "states": ListOf(Text()),
    "parameters": MapOf(ListOf(Either((Number(), Text())), least=3)),
    "sign": Text(),
    "channels": MapOf(Text()),
    "state_limits": MapOf(Number(low=0.0)),
    "positions": MapOf(ListOf(Number(), least=2)),
    "linear": Truth(),
}
"""Entries of a card's file."""

INSIDE = 0.02
"""Share of its range that a constant keeps from both ends."""
SLOPE = 0.5
"""Step of a slope over the prior sd."""


@dataclass(frozen=True, slots=True)
class Range:
    """The values that a parameter may have.

    Attributes
    ----------
    nominal
        the model's value.
    low, high
        the least and the greatest value.
    unit
        unit of all three.
    """

    nominal: float
    low: float
    high: float
    unit: str = "-"

    def __post_init__(self) -> None:
        numbers = (self.nominal, self.low, self.high)
        if not all(isinstance(value, Real) and math.isfinite(value) for value in numbers):
            raise DataError(f"a range is {numbers}; expected three finite numbers: nominal, low, high")
        if not (self.low <= self.nominal <= self.high and self.low < self.high):
            raise DataError(
                f"a range has nominal {self.nominal:g}, low {self.low:g} and high {self.high:g}; expected low <= "
                "nominal <= high and low < high; order them so"
            )

    def ahead(self, sd: float) -> tuple[float, float]:
        """Return the value from which a slope is taken, inside the range, and how many sds it is from the nominal."""
        margin = INSIDE * (self.high - self.low)
        up, down = self.high - margin - self.nominal, self.nominal - self.low - margin
        step = SLOPE * sd if SLOPE * sd <= up else -SLOPE * sd if SLOPE * sd <= down else up if up >= down else -down
        return self.nominal + step, step / sd


RangeLike = Range | Sequence[Any]
"""A range, or (nominal, low, high) or (nominal, low, high, unit)."""


@dataclass(frozen=True, slots=True)
class Card:
    """What a model behind a door is asked for and answers.

    Attributes
    ----------
    readings
        unit of every reading by name, in the order of the answers.
    loads
        names of what is applied or set.
    states
        names of the parameters that a campaign gives test by test.
    parameters
        range of every other parameter, by name, as `Range` or as (nominal, low, high) or (nominal, low, high, unit).
    sign
        what a positive reading is, in words.
    channels
        instrument of a reading by name, where it is not one of its own.
    state_limits
        up to which value a state is looked for, by name.
    linear
        whether readings are proportional to the load, of several loads to all of them together.
    positions
        (x, y) [m] of every reading by name, or nothing.
    Derived:
        ranges: the parameters' ranges.
    """

    readings: Mapping[str, str]
    loads: Sequence[str] = ONE_LOAD
    states: Sequence[str] = ()
    parameters: Mapping[str, RangeLike] = field(default_factory=dict)
    sign: str = ""
    channels: Mapping[str, str] = field(default_factory=dict)
    state_limits: Mapping[str, float] = field(default_factory=dict)
    linear: bool = False
    positions: Mapping[str, Sequence[float]] = field(default_factory=dict)
    ranges: Mapping[str, Range] = field(init=False)

    def __post_init__(self) -> None:
        if not isinstance(self.readings, Mapping):
            raise DataError(f"readings are {self.readings!r}; expected the unit of every reading by name; add them")
        for name, value in {
            "readings": dict(self.readings),
            "loads": tuple(self.loads),
            "states": tuple(self.states),
            "ranges": {name: _range(name, given) for name, given in self.parameters.items()},
            "channels": dict(self.channels),
            "state_limits": {name: float(value) for name, value in self.state_limits.items()},
            "positions": {name: tuple(map(float, place)) for name, place in self.positions.items()},
        }.items():
            object.__setattr__(self, name, value)
        if not self.readings:
            raise DataError("a card names no reading; expected the unit of every reading by name; add them")
        names = [*self.readings, *self.loads, *self.states, *self.parameters]
        twice = sorted({name for name in names if names.count(name) > 1})
        if twice:
            raise DataError(f"a card names {twice[0]!r} twice; expected one reading, load or parameter of a name")
        unknown = [name for name in self.channels if name not in self.readings]
        if unknown:
            raise DataError(f"a card gives a channel to {unknown[0]!r}, which is no reading; expected a reading's name")
        self._check_positions()

    def _check_positions(self) -> None:
        """Check that every reading has a place of two finite coordinates, or none has one."""
        if not self.positions:
            return
        other = sorted(set(self.positions) ^ set(self.readings))
        if other:
            kind = "has no place" if other[0] in self.readings else "is no reading, but has a place"
            raise DataError(
                f"{other[0]!r} {kind} in 'positions' of a card; expected one of every reading, or none at all"
            )
        for name, place in self.positions.items():
            if len(place) != 2 or not all(map(math.isfinite, place)):
                raise DataError(f"'positions' gives {name!r} the place {list(place)}; expected x and y in metres")


def _range(name: str, given: RangeLike) -> Range:
    if isinstance(given, Range):
        return given
    if isinstance(given, str) or not isinstance(given, Sequence) or len(given) not in (3, 4):
        raise DataError(f"parameter {name!r} has the range {given!r}; expected nominal, low, high and, if any, unit")
    try:
        return Range(*given)
    except DataError as error:
        raise DataError(f"parameter {name!r}: {error}") from error


def read_card(path: str | Path) -> Card:
    """Return the card in a JSON file.

    Raises
    ------
    DataError
        no such file, no JSON object, a key that no card has, an entry of another kind, a range that is none.
    """
    return card_from(path, read_json_object(path, "the card of a model"))


def card_from(path: str | Path, content: Mapping[str, Any]) -> Card:
    """Return the card that the JSON object of a file holds; complaints are those of `read_card`."""
    if not isinstance(content.get("readings"), dict):
        raise DataError(f"card {path} has no object 'readings'; expected the unit of every reading by name; add it")
    unknown = [name for name in content if name not in ENTRIES]
    if unknown:
        raise DataError(
            f"card {path} has the key {shown(unknown[0])}; expected among {list(ENTRIES)}; rename or drop it"
        )
    try:
        return Card(**Record({name: ENTRIES[name] for name in content}).take(content))
    except DataError as error:
        raise DataError(f"card {path}: {error}") from error


def card_beside(path: str | Path, card: str | Path | Card | None, linear: bool) -> Card:
    """Return the card that was given, itself or its file, else the one beside a file: its name with .json added.

    Raises
    ------
    DataError
        nothing is there.
    """
    if isinstance(card, Card):
        found = card
    else:
        place = Path(card) if card is not None else Path(f"{path}.json")
        if not place.exists():
            raise DataError(
                f"card {place} is not there: what the model {path} is asked for and answers; expected a JSON file; "
                "write it, or say where it is (--card FILE)"
            )
        found = read_card(place)
    return replace(found, linear=linear or found.linear)
