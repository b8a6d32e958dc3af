"""A twin that keeps its answers: a diagnosis asks for the same few states and loads over and over."""

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from octmip.twin import Effect, State, Twin, predict_states, state_parameters

Key = tuple[tuple[tuple[str, float], ...], float]


class CachedTwin:
    """The twin with its predictions and signatures kept; itself a Twin.

    Attributes
    ----------
    twin
        the model that is asked once for each state and load.
    """

    def __init__(self, twin: Twin) -> None:
        self.twin = twin
        self._strains: dict[Key, NDArray[np.float64]] = {}
        self._signatures: dict[tuple[int, tuple[str, ...], float, Key], NDArray[np.float64]] = {}
        self._asked: dict[int, Effect] = {}  # by identity; held, so that no other effect takes the number of one

    @property
    def gauges(self) -> tuple[str, ...]:
        """Names of the gauges."""
        return self.twin.gauges

    @property
    def parameters(self) -> tuple[str, ...]:
        """Names of the state parameters."""
        return state_parameters(self.twin)

    @property
    def effects(self) -> Mapping[str, Effect]:
        """The twin's own effects."""
        return self.twin.effects

    @property
    def units(self) -> tuple[str, ...] | None:
        """Units of the readings, or None when the twin does not say."""
        units = getattr(self.twin, "units", None)
        return None if units is None else tuple(units)

    @property
    def gauge_positions(self) -> NDArray[np.float64] | None:
        """Places (n_gauges, 2) [m], or None when the twin does not say."""
        places = getattr(self.twin, "gauge_positions", None)
        return None if places is None else np.asarray(places, dtype=np.float64)

    @property
    def _is_linear(self) -> bool:
        return bool(getattr(self.twin, "is_linear_in_load", False))

    def predict(self, state: State, load_factor: float) -> NDArray[np.float64]:
        """Return the strains (n_gauges,) in microstrain."""
        if self._is_linear and load_factor != 1.0:
            return load_factor * self.predict(state, 1.0)
        key = _key(state, load_factor)
        if key not in self._strains:
            strains = np.array(self.twin.predict(dict(key[0]), load_factor), dtype=np.float64)
            strains.flags.writeable = False
            self._strains[key] = strains
        return self._strains[key]

    def predict_states(self, states: NDArray[np.float64], load_factor: float) -> NDArray[np.float64]:
        """Return the strains (n_states, n_gauges), asking the twin once for all states that are new."""
        if self._is_linear and load_factor != 1.0:
            return load_factor * self.predict_states(states, 1.0)
        named = [dict(zip(self.parameters, row.tolist(), strict=True)) for row in states]
        keys = [_key(state, load_factor) for state in named]
        new = [k for k, key in enumerate(keys) if key not in self._strains]
        if new:
            for k, strains in zip(new, predict_states(self.twin, states[new], load_factor), strict=True):
                strains.flags.writeable = False
                self._strains[keys[k]] = strains
        return np.array([self._strains[key] for key in keys])

    def signatures(
        self, effect: Effect, places: tuple[str, ...], state: State, load_factor: float, time: float
    ) -> NDArray[np.float64]:
        """Return the effect's signatures (n_places, n_gauges) at its places.

        A pure power of the load is asked for at load factor 1 only; the time is passed on only where it matters.
        Effects are distinguished as objects: two of one name are two.
        """
        power: int | None = getattr(effect, "load_power", None)
        time = time if getattr(effect, "uses_time", False) else 0.0
        if power is not None and load_factor != 1.0:
            factor = float(load_factor**power)
            return factor * self.signatures(effect, places, state, 1.0, time)
        key = (id(effect), places, time, _key(state, load_factor))
        if key not in self._signatures:
            rows = [effect.signature(self, state, load_factor, place=place, time=time) for place in places]
            self._asked[id(effect)] = effect
            self._signatures[key] = np.array(rows, dtype=np.float64)
        return self._signatures[key]


def _key(state: State, load_factor: float) -> Key:
    return tuple(sorted((name, float(value)) for name, value in state.items() if value != 0.0)), float(load_factor)
