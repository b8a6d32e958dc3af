"""Protocols through which monitor and gap know any model: a Twin, and an Effect that it may lack.

A twin answers one question: which strains do the gauges show in a known state at a known load. An effect is something
that a real structure or a real measuring chain has and the twin lacks; near the twin it changes the readings by

    reading(state, L) = twin(state, L) + size * signature(state, L)        [microstrain]

with `size` in the effect's own physical unit. Both are protocols: a model written by anyone enters by its shape,
without importing this package.
"""

from collections.abc import Mapping
from typing import Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

State = Mapping[str, float]
"""Values of the twin's state parameters by name, damage as a fraction; what it does not name is 0."""


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

    Optional attributes, used where they exist: ``predict_states(states (n, n_parameters), load_factor) -> (n,
    n_gauges)`` (a batch), ``is_linear_in_load`` (strain is proportional to the load factor, so one load is asked for),
    ``gauge_positions`` (n_gauges, 2) [m] and ``outline`` (n, 2) [m] (the map of the report).
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

    def predict(self, state: State, load_factor: float) -> NDArray[np.float64]:
        """Return the strains (n_gauges,) in microstrain at that load, compressive positive."""
        ...


@runtime_checkable
class Effect(Protocol):
    """One thing that the twin lacks.

    Optional: ``predict(twin, state, load_factor, size, place, time) -> (n_gauges,)``, the exact forward map where the
    reading is not linear in the size; ``acts_on_readings``, True where the signature is a map of what `twin.predict`
    returns and of nothing else (two wires swapped, a gauge dead), so that it also acts on what other effects add;
    ``uses_time`` (the signature depends on the time); ``superposes`` (the answers to steps of the load add up, each
    from its own time on); ``signature_error`` (relative sd of the signature at each gauge); ``n_between``
    (neighbouring places between which it may lie, where places sample a continuum); ``seen_by`` (the `QUANTITIES` that
    show it: the next test is chosen among them); ``gauges_of(twin, place)`` (the gauges that a place names: it is
    left out where one was not read; without it a place is read as a gauge, or as several with / or < between them).

    Optional words for the people who read a diagnosis, with {place}, and {first} and {second} for the gauges of a
    pair: ``words`` ("gain of one gauge"), ``words_at`` ("gain of gauge {place}"), ``action`` ("recalibrate gauge
    {place}") and ``says``, what a positive and a negative size mean ("it reads {size} too high", "it reads {size} too
    low"). Without them the effect is called by its name.
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
    def prior_source(self) -> str:
        """Source of the prior scale."""
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
        """The exponent p when the signature is exactly proportional to load_factor**p, else None."""
        ...

    def places(self, twin: Twin) -> tuple[str, ...]:
        """Return the places where the effect may act (gauges, pairs, zones); ("",) when it acts on the whole."""
        ...

    def signature(
        self, twin: Twin, state: State, load_factor: float, place: str = "", time: float = 0.0
    ) -> NDArray[np.float64]:
        """Return the change of the readings (n_gauges,) in microstrain per unit of size; `time` in s from the start."""
        ...


def predict_states(twin: Twin, states: NDArray[np.float64], load_factor: float) -> NDArray[np.float64]:
    """Return the strains (n_states, n_gauges) of states (n_states, n_parameters), by its own batch if it has one."""
    batch = getattr(twin, "predict_states", None)
    if batch is not None:
        return np.asarray(batch(states, load_factor), dtype=np.float64)
    rows = [twin.predict(dict(zip(twin.parameters, row.tolist(), strict=True)), load_factor) for row in states]
    return np.array(rows, dtype=np.float64).reshape(len(states), len(twin.gauges))


def state_parameters(twin: Twin) -> tuple[str, ...]:
    """Return the names of the state parameters; none for a twin that announces none."""
    return tuple(getattr(twin, "parameters", ()))
