"""A Python function as a twin, and every parameter that has a range as an effect that the asset may show.

    def tower(parameters, loads):
        return {"f1": ..., "u_top": ...}

    twin = function_twin(
        tower,
        readings={"f1": "Hz", "u_top": "mm"},
        loads=("force",),
        parameters={"stiffness": (100.0, 80.0, 120.0, "kN/m")},
    )

Each question is put to the function once; its answer is kept.
"""

from collections.abc import Callable, Mapping, Sequence
from copy import copy
from dataclasses import dataclass, replace
from functools import partial
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from octmip.errors import DataError, TwinError
from octmip.gap.doors.card import Card, Range, RangeLike
from octmip.gap.effects.simple import SIGNATURE_ERROR, SimpleEffect
from octmip.input.named_arrays import by_name
from octmip.twin import ONE_LOAD, PURE, Effect, State

Floats = NDArray[np.float64]
Applied = float | Mapping[str, float]
"""What is applied: a number where the model has one load, else all loads by name."""
Function = Callable[[Mapping[str, float], Mapping[str, float]], Any]
"""Values of all parameters and states, and of all loads, by name -> readings by name, or in the order of the card."""
Ask = Callable[[State, Any, Mapping[str, float]], Floats]
"""State, load and values of parameters that are not nominal -> readings (n_gauges,)."""
SHARE = 0.25
"""Prior sd over the width of the range: the range reaches two standard deviations to either side of its middle."""
STEP = 0.25
"""Step of the finite difference over the prior sd: small beside the curvature of a model that is tabulated or rough."""


class FunctionTwin:
    """A function with its card: a twin that asks each question once.

    Attributes
    ----------
    function
        the model.
    card
        what it is asked for and answers.
    effects
        one for every parameter, and others that are added: `with_effects`.
    signature_error
        relative sd of what an error of a load changes; 0 where no run says how good the model is.
    answers
        (n_readings,) of each question, by the values of all parameters, states and loads; shared by all twins of it.
    watch
        called with the number of answers after each new one; None: nothing is.
    drawn
        the twin as it was drawn: itself, or that of which readings of an asset told constants.
    said
        prior sd of each of those constants, by name.
    is_open
        whether no run says them.

    The others are the card's, under the names of `octmip.twin.Twin`.

    Examples
    --------
    >>> twin = function_twin(lambda own, loads: [2.0 * loads["force"]], {"g1": "microstrain"}, loads=["force"])
    >>> twin.gauges, twin.units, twin.loads
    (('g1',), ('microstrain',), ('force',))
    """

    def __init__(self, function: Function, card: Card, effects: Sequence[Effect] = ()) -> None:
        self.function = function
        self.card = card
        self.gauges, self.units = tuple(card.readings), tuple(card.readings.values())
        self.channels = tuple(card.channels.get(name, name) for name in card.readings)
        self.loads, self.parameters = tuple(card.loads), tuple(card.states)
        self.state_limits, self.sign, self.is_linear_in_load = card.state_limits, card.sign, card.linear
        self.signature_error = 0.0
        self.drawn, self.said, self.is_open = self, dict[str, float](), False
        own: list[Effect] = [parameter_effect(name, values, self.ask) for name, values in card.ranges.items()]
        self.effects: Mapping[str, Effect] = {effect.name: effect for effect in (*own, *effects)}
        self.answers: dict[tuple[float, ...], Floats] = {}
        self.watch: Callable[[int], None] | None = None

    @property
    def gauge_positions(self) -> Floats | None:
        """Places (n_readings, 2) [m], or None where the card does not say them."""
        places = self.card.positions
        return np.array([places[name] for name in self.gauges]) if places else None

    @property
    def constants(self) -> dict[str, Range]:
        """Parameters that vary from asset to asset: neither 0 nor an end of their range is the value of a drawing."""
        ranges = self.card.ranges.items()
        return {name: own for name, own in ranges if own.nominal and own.low < own.nominal < own.high}

    def with_effects(self, *effects: Effect) -> "FunctionTwin":
        """Return the twin with more effects that the asset may show, beside all that it has; the answers are shared.

        An effect takes the place of one of the same name.
        """
        twin = copy(self)
        twin.effects = {**self.effects, **{effect.name: effect for effect in effects}}
        return twin

    @property
    def departures(self) -> dict[str, tuple[float, float]]:
        """The drawing's value less the nominal one, and the prior sd, of each constant that readings told, by name."""
        drawn, now = self.drawn.card.ranges, self.card.ranges
        return {name: (drawn[name].nominal - now[name].nominal, sd) for name, sd in self.said.items()}

    def at(
        self,
        values: Mapping[str, float],
        signature_error: float | None,
        said: Mapping[str, float] = MappingProxyType({}),
    ) -> "FunctionTwin":
        """Return the twin with other nominal values of some parameters, and of how well it knows what each does.

        None: no run says that. `said` are the prior sds of those that readings told. The answers are shared.
        """
        twin = copy(self)
        twin.is_open, twin.said = signature_error is None, dict(said)
        error, whose = (SIGNATURE_ERROR, OPEN) if signature_error is None else (signature_error, SOUND)
        ranges = {name: replace(own, nominal=values.get(name, own.nominal)) for name, own in self.card.ranges.items()}
        twin.card = replace(self.card, parameters=ranges)
        own = {
            name: replace(
                parameter_effect(name, ranges[name], twin.ask, whose if name in values else MODEL),
                signature_error=error,
                **(_of_said(twin, name) if name in said else {}),
            )
            for name, effect in self.effects.items()
            if isinstance(getattr(effect, "apply", None), (_Moved, _FromDrawing))
        }
        twin.effects = {**self.effects, **own}
        twin.signature_error = signature_error or 0.0
        return twin

    def slopes(self, state: State, load: Applied) -> Floats:
        """Return what a standard deviation of each of the k constants that readings told changes (k, n_readings).

        They are those of the drawing, by differences, and follow to the constants of today by Broyden's formula.
        """
        if not self.said:
            return np.zeros((0, len(self.gauges)))
        drawn, sds = self.drawn, np.array(list(self.said.values()))
        before, found = drawn.ask(state, load, {}), np.zeros((len(sds), len(self.gauges)))
        for k, (name, sd) in enumerate(self.said.items()):
            there, step = drawn.card.ranges[name].ahead(sd)
            found[k] = (drawn.ask(state, load, {name: there}) - before) / step
        moved = -np.array([departure for departure, _ in self.departures.values()]) / sds
        missed = self.ask(state, load, {}) - before - moved @ found
        return np.asarray(found + np.outer(moved, missed) / max(float(moved @ moved), 1e-300))

    def predict(self, state: State, load_factor: Applied) -> Floats:
        """Return the readings (n_readings,) at the parameters' nominal values."""
        return self.ask(state, load_factor, {})

    def ask(self, state: State, load: Applied, values: Mapping[str, float]) -> Floats:
        """Return the readings (n_readings,) with some parameters at other values; each is asked for once."""
        parameters = {name: own.nominal for name, own in self.card.ranges.items()} | dict(values)
        parameters |= {name: float(state.get(name, 0.0)) for name in self.card.states}
        loads = self._by_name(load)
        key = (*parameters.values(), *loads.values())
        if key not in self.answers:
            self.answers[key] = self._readings(self.function(parameters, loads))
            if self.watch is not None:
                self.watch(len(self.answers))
        return self.answers[key]

    def _by_name(self, load: Applied) -> dict[str, float]:
        """Return the loads in the order of the card.

        Raises
        ------
        TwinError
            they are not those of the card.
        """
        given = dict(load) if isinstance(load, Mapping) else dict.fromkeys(self.loads[:1], load)
        if set(given) != set(self.loads):
            raise TwinError(
                f"the model was asked for the loads {load if isinstance(load, Mapping) else f'{load:g}'}; expected "
                f"{list(self.loads)} by name; give them all"
            )
        return {name: float(given[name]) for name in self.loads}

    def _readings(self, answer: Any) -> Floats:
        """Return an answer as numbers in the order of the card; one column of an array is an answer too."""
        if isinstance(answer, np.ndarray) and answer.shape == (len(self.gauges), 1) and answer.dtype.names is None:
            answer = answer[:, 0]
        try:
            rows, _ = by_name(answer, self.gauges, "the model's answer")
        except DataError as error:
            raise TwinError(f"{error}; correct the model, or its card") from error
        found: Floats = rows[0] if len(rows) == 1 else rows
        found.flags.writeable = False
        return found


def function_twin(
    function: Function,
    readings: Mapping[str, str],
    parameters: Mapping[str, RangeLike] | None = None,
    loads: Sequence[str] = ONE_LOAD,
    states: Sequence[str] = (),
    sign: str = "",
    channels: Mapping[str, str] | None = None,
    linear: bool = False,
    positions: Mapping[str, Sequence[float]] | None = None,
) -> FunctionTwin:
    """Return the twin of a function ``f(parameters, loads) -> readings``.

    Parameters
    ----------
    function
        the model; parameters and loads come by name, readings go by name or in the order of `readings`.
    readings
        unit of every reading by name.
    parameters
        (nominal, low, high, unit) of every parameter by name; each is an effect that the asset may show.
    loads
        names of what is applied or set, columns of a campaign.
    states
        names of parameters whose values a campaign gives test by test; 0 where it does not.
    sign
        what a positive reading is, in words.
    channels
        instrument of a reading by name, where one gives several.
    linear
        whether readings are proportional to the load, of several loads to all of them together.
    positions
        (x, y) [m] of every reading by name: the page of a diagnosis then shows the place.

    Raises
    ------
    DataError
        a name that comes twice, a range that is none.

    Examples
    --------
    >>> twin = function_twin(lambda own, loads: [loads["force"] * own["stiffness"]], {"g1": "microstrain"},
    ...     parameters={"stiffness": (2.0, 1.0, 3.0, "")}, loads=["force"])
    >>> twin.predict({}, 10.0)
    array([20.])
    """
    limits = dict.fromkeys(states, 1.0)
    card = Card(readings, loads, states, parameters or {}, sign, channels or {}, limits, linear, positions or {})
    return FunctionTwin(function, card)


@dataclass(frozen=True, slots=True, eq=False)
class _Moved:
    """The readings with a parameter at another value than the nominal one."""

    name: str
    nominal: float
    sign: float
    ask: Ask

    def __call__(self, readings: Floats, size: float, load: Any, place: str, state: State) -> Floats:
        moved = self.ask(state, load, {self.name: self.nominal + self.sign * size} if size else {})
        return readings + moved - self.ask(state, load, {})


@dataclass(frozen=True, slots=True, eq=False)
class _FromDrawing:
    """The readings with a change of a constant that is open, where without it the drawing's value is to be expected.

    The constant is `departure` below the drawing's value, and goes back there along its slope: both together are the
    readings at the drawing's value and the change.
    """

    name: str
    drawn: float
    departure: float
    ask: Ask
    slope: Callable[[State, Any], Floats]

    def __call__(self, readings: Floats, size: float, load: Any, place: str, state: State) -> Floats:
        if not size:
            return readings
        moved = self.ask(state, load, {self.name: self.drawn + size}) - self.ask(state, load, {})
        return readings + moved - self.departure * self.slope(state, load)


def _of_said(twin: FunctionTwin, name: str) -> dict[str, Any]:
    """Return the slope of a constant that readings told; the change of an open one is from the drawing's value."""
    slope, drawn = partial(_today, twin, name), twin.drawn.card.ranges[name]
    if not twin.is_open:
        return {"slope": slope}
    moved = _FromDrawing(name, drawn.nominal, twin.departures[name][0], twin.ask, slope)
    return {"apply": moved, "bounds": _bounds(drawn), "slope": slope}


def _today(twin: FunctionTwin, name: str, state: State, load: Applied) -> Floats:
    """Return the slope of a constant at its most likely value, where a change that is large has led it."""
    return np.asarray(twin.slopes(state, load)[list(twin.said).index(name)] / twin.said[name])


def _bounds(own: Range) -> tuple[float, float]:
    """Return the least and the greatest change of a parameter."""
    is_at_end = own.nominal in (own.low, own.high)
    return (0.0, own.high - own.low) if is_at_end else (own.low - own.nominal, own.high - own.nominal)


MODEL, SOUND, OPEN = "the model's", "the sound asset's", "the sound asset's own, which no run says"
"""Whose value of a parameter an effect is a change from."""


def parameter_effect(name: str, own: Range, ask: Ask, whose: str = MODEL) -> SimpleEffect:
    """Return the effect that the asset's value of a parameter with a range is another than the model's.

    Its size is the asset's value less the nominal one; how far it is below where the nominal value is the greatest.
    """
    called, width = name.replace("_", " "), own.high - own.low
    is_at_end, below = own.nominal in (own.low, own.high), own.nominal == own.high
    unit = "" if own.unit in PURE else f" {own.unit}"
    of = whose if whose is OPEN else f"{whose} {own.nominal:.4g}{unit}"
    way = "below" if below else "above"
    return SimpleEffect(
        name=name,
        unit=own.unit,
        prior_sd=(2 * SHARE if is_at_end else SHARE) * width,
        apply=_Moved(name, own.nominal, -1.0 if below else 1.0, ask),
        bounds=_bounds(own),
        parameter=f"{called} {way} {of}",
        words=called,
        action=f"correct the {called}",
        says=(f"it is {{size}} {way} {of}", f"it is {{size}} below {of}"),
        step=STEP,
    )
