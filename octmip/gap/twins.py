"""Twins around a twin: one with what it lacked, which can be diagnosed again, and one that keeps its answers.

A diagnosis asks for the same few states and loads over and over. Every answer of somebody else's model passes the twin
that keeps them, so there it is checked: that it came, its shape, that it is finite.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from octmip.errors import DataError, OctmipError, TwinError
from octmip.input.named_arrays import by_name
from octmip.twin import (
    Effect,
    Load,
    Loads,
    State,
    Twin,
    TwinAround,
    channels_of,
    load_of,
    load_words,
    positions_of,
    predict_states,
    units_of,
)

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Addition:
    """One effect at one place with its size.

    Attributes
    ----------
    effect
        the effect.
    place
        where it acts.
    size
        in the effect's unit.

    Examples
    --------
    >>> warm = SimpleEffect("warm", "K", 10.0, lambda readings, size: readings - 12.0 * size)
    >>> Addition(warm, "", 3.0).size
    3.0
    """

    effect: Effect
    place: str
    size: float


@dataclass(frozen=True, slots=True, eq=False)
class AugmentedTwin(TwinAround):
    """A twin with additions, applied in their order: what the structure does first, what the measuring chain does last.

    Attributes
    ----------
    twin
        the model.
    additions
        what it lacked.
    difference
        of the asset before any effect, in a state and at a load (n_gauges,); None: 0.

    Examples
    --------
    >>> twin = function_twin(lambda own, loads: [2.0 * loads["force"]], {"g1": "microstrain"}, loads=["force"])
    >>> warm = SimpleEffect("warm", "K", 10.0, lambda readings, size: readings - 12.0 * size)
    >>> AugmentedTwin(twin, (Addition(warm, "", 3.0),)).predict({}, 100.0)
    array([164.])
    """

    twin: Twin
    additions: tuple[Addition, ...]
    difference: Callable[[State, Load], Floats] | None = None

    @property
    def units(self) -> tuple[str, ...]:
        """Unit of every reading."""
        return units_of(self.twin)

    @property
    def channels(self) -> tuple[str, ...]:
        """Instrument of every reading."""
        return channels_of(self.twin)

    @property
    def gauge_positions(self) -> Floats | None:
        """Places (n_gauges, 2) [m], or None."""
        return positions_of(self.twin)

    def predict(self, state: State, load_factor: Load | Mapping[str, float], time: float = 0.0) -> Floats:
        """Return the readings (n_gauges,), effects included, `time` s from the start of the campaign."""
        if isinstance(load_factor, Mapping) and not isinstance(load_factor, Loads):  # in the order of the twin
            names = sorted(load_factor, key=lambda name: (*self.loads, name).index(name))
            load_factor = load_of(tuple(names), tuple(load_factor[name] for name in names))
        strain = np.array(self.twin.predict(state, load_factor), dtype=np.float64)
        if self.difference is not None:
            strain = strain + self.difference(state, load_factor)
        for k, addition in enumerate(self.additions):
            before = replace(self, additions=self.additions[:k])
            forward = getattr(addition.effect, "predict", None)
            if forward is not None:
                strain = np.asarray(forward(before, state, load_factor, addition.size, addition.place, time))
            else:
                change = addition.effect.signature(before, state, load_factor, place=addition.place, time=time)
                strain = strain + addition.size * change
        return np.asarray(strain, dtype=np.float64)


Key = tuple[tuple[tuple[str, float], ...], Load]


class CachedTwin(TwinAround):
    """The twin with its predictions and signatures kept; itself a Twin.

    Attributes
    ----------
    twin
        the model that is asked once for each state and load.
    units, channels
        (n_gauges,) unit and instrument of every reading; no units where the model does not say.

    Examples
    --------
    >>> twin = function_twin(lambda own, loads: [2.0 * loads["force"]], {"g1": "microstrain"}, loads=["force"])
    >>> CachedTwin(twin).predict({}, 3.0)
    array([6.])
    """

    def __init__(self, twin: Twin) -> None:
        self.twin = twin
        self.units = None if getattr(twin, "units", None) is None else units_of(twin)
        self.channels = channels_of(twin)
        self._strains: dict[Key, NDArray[np.float64]] = {}
        self._signatures: dict[tuple[int, tuple[str, ...], float, Key], NDArray[np.float64]] = {}
        self._asked: dict[int, Effect] = {}  # by identity; held, so that no other effect takes the number of one

    def __getstate__(self) -> dict[str, Any]:
        """Return what a copy in another process has: all but the signatures, which are kept by identity."""
        return {**self.__dict__, "_signatures": {}, "_asked": {}}

    def in_units(self, units: Mapping[str, str]) -> "CachedTwin":
        """Return the twin with the units that somebody states, microstrain for readings that `units` leaves out.

        Raises
        ------
        TwinError
            the model says its units itself, and another one for some reading.
        """
        own = dict(zip(self.gauges, units_of(self), strict=True))
        other = next((name for name in units if self.units is not None and units[name] != own[name]), None)
        if other is not None:
            raise TwinError(
                f"the twin says that {other!r} is in {own[other]}, but {units[other]} was given; expected its own; "
                "leave the unit out, or correct the twin"
            )
        stated = CachedTwin(self.twin)
        stated.units = tuple({**own, **units}[name] for name in self.gauges)
        return stated

    @property
    def gauge_positions(self) -> NDArray[np.float64] | None:
        """Places (n_gauges, 2) [m], or None when the twin does not say."""
        return positions_of(self.twin)

    @property
    def is_linear_in_load(self) -> bool:
        """Whether readings are proportional to the load."""
        return bool(getattr(self.twin, "is_linear_in_load", False))

    def predict(self, state: State, load_factor: Load) -> NDArray[np.float64]:
        """Return the readings (n_gauges,)."""
        if self.is_linear_in_load and not isinstance(load_factor, Loads) and load_factor != 1.0:
            return load_factor * self.predict(state, 1.0)
        key = _key(state, load_factor)
        if key not in self._strains:
            with self._answering(state, load_factor):
                answer = self.twin.predict(dict(key[0]), load_factor)
            self._keep(key, answer)
        return self._strains[key]

    def checked(self, ask: Callable[[], ArrayLike], state: State, load: Load) -> NDArray[np.float64]:
        """Return the readings (n_gauges,) that somebody else's model is asked for; they are not kept.

        Raises
        ------
        TwinError
            it fails, or answers another number of readings or one that is not finite.
        """
        with self._answering(state, load):
            answer = ask()
        return self._checked(answer, self.name, f"another value of its parameters at {load_words(self.loads, load)}")

    @property
    def name(self) -> str:
        """What the model is called in a message: its class."""
        return f"the twin {type(self.twin).__name__}"

    @contextmanager
    def _answering(self, state: State, load: Load, who: str = "") -> Iterator[None]:
        """Within it, what somebody else's model raises becomes one sentence."""
        try:
            yield
        except OctmipError:
            raise
        except (Exception, SystemExit) as error:  # a program's own exit is no answer
            of = ", ".join(f"{name} {value:g}" for name, value in state.items() if value) or "the healthy state"
            at = f" at {load_words(self.loads, load)}" if self.loads else ""
            raise TwinError(
                f"{who or self.name} raised {type(error).__name__} for {of}{at}: {error}; expected readings; correct it"
            ) from error

    def _keep(self, key: Key, answer: ArrayLike) -> None:
        at = load_words(self.loads, key[1])
        strains = self._checked(answer, self.name, f"{dict(key[0]) or 'the healthy state'}{f' at {at}' if at else ''}")
        strains.flags.writeable = False
        self._strains[key] = strains

    def _checked(self, answer: ArrayLike, who: str, where: str) -> NDArray[np.float64]:
        """Return an answer as floats (n_gauges,).

        Raises
        ------
        TwinError
            it has another shape, is no number or not finite.
        """
        try:
            rows, _ = by_name(answer, self.gauges, f"{who} for {where}")
        except DataError as error:
            raise TwinError(f"{error}; correct it") from error
        if len(rows) != 1:
            raise TwinError(f"{who} answers {len(rows)} rows for {where}; expected one number for each reading")
        found: NDArray[np.float64] = rows[0]
        if not np.isfinite(found).all():
            k = int(np.flatnonzero(~np.isfinite(found))[0])
            raise TwinError(
                f"{who} answers {found[k]} for reading {self.gauges[k]} ({where}); expected a finite number; correct it"
            )
        return found

    def predict_states(self, states: NDArray[np.float64], load_factor: Load) -> NDArray[np.float64]:
        """Return the readings (n_states, n_gauges), asking the twin once for all states that are new."""
        if self.is_linear_in_load and not isinstance(load_factor, Loads) and load_factor != 1.0:
            return load_factor * self.predict_states(states, 1.0)
        named = [dict(zip(self.parameters, row.tolist(), strict=True)) for row in states]
        keys = [_key(state, load_factor) for state in named]
        new = [k for k, key in enumerate(keys) if key not in self._strains]
        if new:
            with self._answering(named[new[0]], load_factor):
                answers = predict_states(self.twin, states[new], load_factor)
            if len(answers) != len(new):
                raise TwinError(
                    f"{self.name}.predict_states answers {len(answers)} of {len(new)} states; expected a row for each"
                )
            for k, answer in zip(new, answers, strict=True):
                self._keep(keys[k], answer)
        return np.array([self._strains[key] for key in keys])

    def signatures(
        self, effect: Effect, places: tuple[str, ...], state: State, load_factor: Load, time: float
    ) -> NDArray[np.float64]:
        """Return the effect's signatures (n_places, n_gauges) at its places.

        A pure power of the load is asked for at load factor 1 only; the time is passed on only where it matters.
        Effects are distinguished as objects: two of one name are two.
        """
        power: int | None = getattr(effect, "load_power", None)
        time = time if getattr(effect, "uses_time", False) else 0.0
        if power is not None and not isinstance(load_factor, Loads) and load_factor != 1.0:
            factor = float(load_factor**power)
            return factor * self.signatures(effect, places, state, 1.0, time)
        key = (id(effect), places, time, _key(state, load_factor))
        if key not in self._signatures:
            with self._answering(state, load_factor, f"effect {effect.name}"):
                rows = rows_at(effect, self, state, load_factor, places, time)
            self._asked[id(effect)] = effect
            if not (isinstance(rows, np.ndarray) and rows.shape[1:] == (len(self.gauges),) and np.isfinite(rows).all()):
                named = zip(places, rows, strict=True)
                rows = [self._checked(row, f"effect {effect.name}", f"place {place!r}") for place, row in named]
            self._signatures[key] = np.array(rows).reshape(len(places), len(self.gauges))
        return self._signatures[key]


def rows_at(
    effect: Effect, twin: Twin, state: State, load: Load, places: Sequence[str], time: float = 0.0
) -> Floats | list[Floats]:
    """Return an effect's signatures at its places, row by row, from one question where the effect answers it."""
    at_once: Callable[..., Floats] | None = getattr(effect, "at_places", None)
    if at_once is not None:
        return at_once(twin, state, load, places, time)
    return [effect.signature(twin, state, load, place=place, time=time) for place in places]


def _key(state: State, load: Load) -> Key:
    return tuple(sorted((name, float(value)) for name, value in state.items() if value != 0.0)), load
