"""The augmented twin: a twin with what it lacked, itself a Twin, so that it can be diagnosed again."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from octmip.twin import Effect, Load, State, Twin, TwinAround, channels_of, units_of

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
        places = getattr(self.twin, "gauge_positions", None)
        return None if places is None else np.asarray(places, dtype=np.float64)

    def predict(self, state: State, load_factor: Load, time: float = 0.0) -> Floats:
        """Return the readings (n_gauges,), effects included, `time` s from the start of the campaign."""
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
