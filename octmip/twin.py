"""Protocols through which monitor and gap know any model: a Twin, and an Effect that it may lack.

A twin answers one question: what do the gauges show in a known state under known loads. An effect is something that a
real machine or a real measuring chain has and the twin lacks; near the twin it changes the readings by

    reading(state, L) = twin(state, L) + size * signature(state, L)        [each reading in its own unit]

with `size` in the effect's own physical unit. Both are protocols: a model written by anyone enters by its shape,
without importing this package.

A "gauge" is whatever gives a reading: a strain gauge, an accelerometer, a thermocouple, a natural frequency, the force
at a phase of a cycle. A "load" is whatever was applied or set: a load factor, a frequency, an amplitude, a heating
power. A twin that announces neither units nor loads reads microstrain at a load factor.
"""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from octmip.errors import TwinError

State = Mapping[str, float]
"""Values of the twin's state parameters by name, damage as a fraction; what it does not name is 0."""


@dataclass(frozen=True, slots=True, repr=False)
class Loads(Mapping[str, float]):
    """The loads and settings of a reading by name, of a twin that announces several or none: a mapping with a hash.

    Formatted, it says what was applied: ``f"{loads:g}"`` is "frequency 2, amplitude 0.5".

    Attributes
    ----------
    names
        of the loads, in the order in which the twin announces them.
    amounts
        one for each.
    """

    names: tuple[str, ...]
    amounts: tuple[float, ...]

    def __getitem__(self, name: str) -> float:
        try:
            return self.amounts[self.names.index(name)]
        except ValueError:
            raise KeyError(name) from None

    def __iter__(self) -> Iterator[str]:
        return iter(self.names)

    def __len__(self) -> int:
        return len(self.names)

    def __lt__(self, other: "Loads") -> bool:
        return self.amounts < other.amounts

    def __format__(self, spec: str) -> str:
        return ", ".join(f"{name} {value:{spec or 'g'}}" for name, value in self.items())

    def __repr__(self) -> str:
        return f"Loads({format(self, '.6g')})"


Load = float | Loads
"""What was applied: a float where the twin has one load, else `Loads`."""

ONE_LOAD = ("load_factor",)
"""The loads of a twin that announces none."""
MICROSTRAIN = "microstrain"
"""Unit of the readings of a twin that announces none."""
STRAINS = (MICROSTRAIN, "strain")
"""Units of readings of strain gauges: what only such a gauge can have is asked of these alone."""
PURE = ("-", "1", "")
"""Units of a pure number, which is written without one."""
MIXED = "standard deviations of one reading"
"""Unit of what is made of readings of several units together."""

QUANTITIES = {
    "applied_load": "the load, by a second load cell or a known mass",
    "shunt_reading": "readings while the bridges are shunted",
    "channel_order": "which channel answers when one gauge is touched",
    "gauge_placement": "place and angle of a gauge on the structure",
    "deflection": "the tip deflection under a known load",
    "frequency": "the first natural frequencies",
    "thermal_zero": "readings at zero load and another temperature",
}
"""Quantities that can be measured beside strain under load; an effect's `seen_by` names those that show it."""


@runtime_checkable
class Twin(Protocol):
    """A model of the structure with gauges on it.

    Optional attributes, used where they exist:

    * ``loads``: names of the loads and settings, which are columns of a campaign. A twin with one load gets it as a
      float, a twin with several loads, or with none, gets a mapping by name (`Loads`). A twin without this attribute
      has one load, ``load_factor``;
    * ``units``: unit of every reading, by gauge or in the order of the gauges. By default microstrain;
    * ``sign``: what a positive reading is, in words; or ``compressive_positive``, True (the default) or False;
    * ``channels``: instrument of every reading, in the order of the gauges. It is needed where one instrument gives
      several readings (a force sensor at twelve phases of a cycle), because its faults act on all of them. By default
      every gauge is an instrument of its own;
    * ``predict_states(states (n, n_parameters), load_factor) -> (n, n_gauges)``: the readings of many states at once;
    * ``state_limits``: greatest value of each state parameter, by name, up to which an unknown state is
      looked for. A parameter that it leaves out is taken as stated. By default every parameter is looked for up to 1;
    * ``is_linear_in_load``: True where readings are proportional to the load, of several loads to all of them together;
      a twin of one load is then asked at one load only;
    * ``gauge_positions`` (n_gauges, 2) [m] and ``outline`` (n, 2) [m]: for the map of the report.
    """

    @property
    def gauges(self) -> tuple[str, ...]:
        """Names of the gauges, in the order of the readings."""
        ...

    @property
    def parameters(self) -> tuple[str, ...]:
        """Names of the state parameters."""
        ...

    @property
    def effects(self) -> Mapping[str, "Effect"]:
        """Effects that a real structure of this kind may have and the model lacks, by name."""
        ...

    def predict(self, state: State, load_factor: Any) -> NDArray[np.float64]:
        """Return the readings (n_gauges,) in their units at that load, a float or, of several, `Loads`."""
        ...


@runtime_checkable
class Effect(Protocol):
    """One thing that the twin lacks.

    Optional attributes, used where they exist:

    * ``predict(twin, state, load_factor, size, place, time) -> (n_gauges,)``: the exact forward map, where the reading
      is not linear in the size;
    * ``acts_on_readings``: True where the signature is a map of what `twin.predict` returns and of nothing else (two
      wires swapped, a gauge dead). Such an effect also acts on what other effects add;
    * ``bounds``: the least and the greatest possible size;
    * ``uses_time``: True where the signature depends on the time;
    * ``superposes``: True where the answers to steps of the load add up, each from its own time on;
    * ``signature_error``: relative standard deviation of the signature, of all gauges or one for each;
    * ``n_between``: where places sample a continuum, the number of neighbouring places between which the effect may
      lie;
    * ``seen_by``: the `QUANTITIES` that show it; the next test is chosen among them;
    * ``gauges_of(twin, place)``: the gauges that a place names. A place is left out where one of them was not read. By
      default a place is the name of a gauge, or of several with / or < between them.

    Optional words for the people who read a diagnosis: ``words`` ("gain of one gauge"), ``words_at`` ("gain of gauge
    {place}"), ``action`` ("recalibrate gauge {place}") and ``says``, what a positive and what a negative size mean ("it
    reads {size} too high", "it reads {size} too low"). They may hold {place}, and {first} and {second} for the gauges
    of a pair. An effect without them is called by its name.
    """

    @property
    def name(self) -> str:
        """Name in snake_case."""
        ...

    @property
    def parameter(self) -> str:
        """Quantity that the size measures, in words."""
        ...

    @property
    def unit(self) -> str:
        """Unit of the size."""
        ...

    @property
    def prior_mean(self) -> float:
        """Expected size before any data, in `unit`."""
        ...

    @property
    def prior_sd(self) -> float:
        """Scale of the size before any data, in `unit`."""
        ...

    @property
    def is_one_sided(self) -> bool:
        """Whether the size cannot be negative."""
        ...

    @property
    def separated_by(self) -> str:
        """Observation that separates the effect from its nearest confounder."""
        ...

    @property
    def load_power(self) -> int | None:
        """The exponent p when the signature is exactly proportional to load_factor**p, else None.

        It holds for a twin of one load; with several loads the signature is asked for at every one.
        """
        ...

    def places(self, twin: Twin) -> tuple[str, ...]:
        """Return the places where the effect may act (gauges, pairs, zones); ("",) when it acts on the whole."""
        ...

    def signature(
        self, twin: Twin, state: State, load_factor: Any, place: str = "", time: float = 0.0
    ) -> NDArray[np.float64]:
        """Return the change of the readings (n_gauges,) per unit of size; `time` in s from the start."""
        ...


def predict_states(twin: Twin, states: NDArray[np.float64], load_factor: Load) -> NDArray[np.float64]:
    """Return the readings (n_states, n_gauges) of states (n_states, n_parameters), by its own batch if it has one."""
    batch = getattr(twin, "predict_states", None)
    if batch is not None:
        return np.asarray(batch(states, load_factor), dtype=np.float64)
    rows = [twin.predict(dict(zip(twin.parameters, row.tolist(), strict=True)), load_factor) for row in states]
    return np.array(rows, dtype=np.float64).reshape(len(states), len(twin.gauges))


def state_parameters(twin: Twin) -> tuple[str, ...]:
    """Return the names of the state parameters; none for a twin that announces none."""
    return tuple(getattr(twin, "parameters", ()))


def loads_of(twin: Twin) -> tuple[str, ...]:
    """Return the names of the loads and settings; the load factor for a twin that announces none."""
    return tuple(getattr(twin, "loads", ONE_LOAD))


def units_of(twin: Twin) -> tuple[str, ...]:
    """Return the unit of every reading, in the order of the gauges; microstrain for a twin that announces none.

    Raises
    ------
    TwinError
        it announces units, but not one for each reading.
    """
    units = getattr(twin, "units", None)
    if units is None:
        return (MICROSTRAIN,) * len(twin.gauges)
    if isinstance(units, Mapping):
        missing = [name for name in twin.gauges if name not in units]
        if missing:
            raise TwinError(f"the twin gives no unit for its reading {missing[0]!r}; expected one for each; add it")
        return tuple(str(units[name]) for name in twin.gauges)
    return _one_each(twin, "units", units)


def channels_of(twin: Twin) -> tuple[str, ...]:
    """Return the instrument of every reading, in the order of the gauges; the gauge itself where none is announced."""
    return _one_each(twin, "channels", getattr(twin, "channels", twin.gauges))


def positions_of(twin: Twin) -> NDArray[np.float64] | None:
    """Return the places of the gauges (n_gauges, 2) [m]; None for a twin that does not say them."""
    places = getattr(twin, "gauge_positions", None)
    return None if places is None else np.asarray(places, dtype=np.float64)


def _one_each(twin: Twin, what: str, given: Sequence[str]) -> tuple[str, ...]:
    if len(given) != len(twin.gauges):
        raise TwinError(
            f"the twin gives {len(given)} {what} for {len(twin.gauges)} readings; expected one for each; give them in "
            "the order of its gauges"
        )
    return tuple(str(one) for one in given)


def state_limits_of(twin: Twin) -> tuple[float, ...]:
    """Return up to which value each state parameter is looked for; 0 where it is taken as stated."""
    limits = getattr(twin, "state_limits", None)
    return tuple(1.0 if limits is None else float(limits.get(name, 0.0)) for name in state_parameters(twin))


def sign_of(twin: Twin) -> str:
    """Return what a positive reading is, in words; "" where the twin does not say and reads no strain."""
    own = str(getattr(twin, "sign", ""))
    if own:
        return own
    has_strain = any(unit in STRAINS for unit in units_of(twin))
    is_compressive = bool(getattr(twin, "compressive_positive", True))
    return f"{'compressive' if is_compressive else 'tensile'} strain positive" if has_strain else ""


def load_of(names: tuple[str, ...], amounts: tuple[float, ...]) -> Load:
    """Return the load as a twin with loads of these names is asked for it: a float where it has one."""
    return float(amounts[0]) if len(names) == 1 else Loads(names, tuple(float(value) for value in amounts))


def amounts_of(load: Load) -> tuple[float, ...]:
    """Return the amounts of a load, one for each name; loads of one twin are ordered by them."""
    return load.amounts if isinstance(load, Loads) else (float(load),)


def load_words(names: tuple[str, ...], load: Load) -> str:
    """Return a load in words: "load factor 2", "frequency 2, amplitude 0.5"; "" where nothing is applied."""
    pairs = zip(names, amounts_of(load), strict=True)
    return ", ".join(f"{name.replace('_', ' ')} {value:g}" for name, value in pairs)


def is_zero(load: Load) -> bool:
    """Return whether the one load is zero; several loads have no zero of their own."""
    return not isinstance(load, Loads) and not math.fabs(load) > 0.0


class TwinAround:
    """What a twin made of another one passes on unchanged: its gauges, states, loads and effects.

    Attributes
    ----------
    twin
        the other one.
    """

    __slots__ = ()
    twin: Twin

    @property
    def gauges(self) -> tuple[str, ...]:
        """Names of the gauges."""
        return self.twin.gauges

    @property
    def parameters(self) -> tuple[str, ...]:
        """Names of the state parameters."""
        return state_parameters(self.twin)

    @property
    def state_limits(self) -> dict[str, float]:
        """Up to which value each state parameter is looked for."""
        return dict(zip(self.parameters, state_limits_of(self.twin), strict=True))

    @property
    def loads(self) -> tuple[str, ...]:
        """Names of the loads and settings."""
        return loads_of(self.twin)

    @property
    def effects(self) -> Mapping[str, Effect]:
        """The twin's own effects."""
        return self.twin.effects
