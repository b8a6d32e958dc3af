"""The wing as a twin: the model that a monitor or a diagnosis needs, by shape and without knowing this package.

Full and reduced wing answer alike; a twin is one of them and the effects that a real wing may have besides. The
effects always need the full wing (their forces act on its nodes): a twin made from a file builds it when an effect is
asked for.
"""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path

from numpy.typing import ArrayLike

from femlib.arrays import FloatArray
from femlib.errors import InputError
from femlib.rom import ReductionSettings
from femlib.wing.effects import WingEffect, wing_effects
from femlib.wing.model import Wing, uav_wing
from femlib.wing.reduced import ReducedWing, reduce_wing


@dataclass(frozen=True, slots=True, eq=False)
class WingTwin:
    """A wing, full or reduced, that predicts gauge strains.

    Attributes
    ----------
    model : Wing or ReducedWing
        The model.
    effects : mapping
        What a real wing may have that the model lacks, by name.
    make_wing : callable, optional
        Makes the full wing of a reduced model, or gives the one that is there.
    """

    model: Wing | ReducedWing
    effects: Mapping[str, WingEffect] = field(default_factory=dict)
    make_wing: Callable[[], Wing] | None = None

    @property
    def wing(self) -> Wing:
        """The full wing.

        Raises
        ------
        InputError
            If the model is reduced and nothing makes its full wing.
        """
        if isinstance(self.model, Wing):
            return self.model
        if self.make_wing is None:
            raise InputError(
                "this twin knows only the reduced wing; expected make_wing, which makes the full one; give it"
            )
        return self.make_wing()

    @property
    def gauges(self) -> tuple[str, ...]:
        """Names of the gauges."""
        return self.model.gauge_names

    @property
    def parameters(self) -> tuple[str, ...]:
        """Names of the damage parameters."""
        return self.model.parameters

    @property
    def is_linear_in_load(self) -> bool:
        """Whether strain is proportional to the load factor: it is."""
        return True

    @property
    def gauge_positions(self) -> FloatArray | None:
        """Places (n_gauges, 2) of the gauges, x aft of the spar and y outboard [m]."""
        return self.model.gauge_positions

    @property
    def outline(self) -> FloatArray | None:
        """Closed polygon (5, 2) of the planform in (x, y) [m]."""
        return self.model.outline()

    def predict_states(self, states: FloatArray, load_factor: float) -> FloatArray:
        """Return the strains (n_states, n_gauges) of damage fractions (n_states, n_parameters)."""
        return self.model.strains_microstrain(states, load_factor)

    def predict(self, state: Mapping[str, float], load_factor: float) -> FloatArray:
        """Return the strains (n_gauges,) in microstrain of a state of damage fractions, compressive positive."""
        return self.model.strain_microstrain(state, load_factor)

    def error_bound(self, states: ArrayLike, load_factor: float) -> FloatArray:
        """Return bounds (n_states, n_gauges) [microstrain] of the difference of `predict_states` from the full wing."""
        return self.model.error_bound_microstrain(states, load_factor)


def uav_twin() -> WingTwin:
    """Return the twin of the UAV wing by its reduced model, with its 24 installed gauges and its effects."""
    return reduced_twin(uav_wing())


def full_twin() -> WingTwin:
    """Return the same by the full model."""
    wing = uav_wing()
    return WingTwin(wing, wing_effects(wing))


def reduced_twin(wing: Wing, settings: ReductionSettings | None = None) -> WingTwin:
    """Return the twin of any wing by its reduced model, with the effects that a real one may have."""
    return WingTwin(reduce_wing(wing, settings), wing_effects(wing), lambda: wing)


def saved_twin(path: str | Path, make_wing: Callable[[], Wing] = uav_wing) -> WingTwin:
    """Return the twin of a reduced model that `ReducedWing.save` wrote.

    It answers at once; the full wing is made when an effect or the wing itself is first asked for.

    Raises
    ------
    InputError
        If the file is no reduced wing; when the full wing is made, if it is another one.
    """
    reduced = ReducedWing.load_file(path)
    made = _OnDemand(reduced, make_wing)
    return WingTwin(reduced, made, made.wing)


class _OnDemand(Mapping[str, WingEffect]):
    """The effects of a reduced wing and its full wing, each made once when it is first asked for."""

    def __init__(self, reduced: ReducedWing, make_wing: Callable[[], Wing]) -> None:
        self._reduced = reduced
        self._make_wing = make_wing

    def wing(self) -> Wing:
        return self._wing

    @cached_property
    def _wing(self) -> Wing:
        wing = self._make_wing()
        if wing.model_hash != self._reduced.model_hash:
            raise InputError(
                f"the reduced wing was made of the wing {self._reduced.model_hash[:12]} but the full one is "
                f"{wing.model_hash[:12]}; expected the same; give make_wing, or reduce this wing again"
            )
        return wing

    @cached_property
    def _effects(self) -> Mapping[str, WingEffect]:
        return wing_effects(self._wing)

    def __getitem__(self, name: str) -> WingEffect:
        return self._effects[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._effects)

    def __len__(self) -> int:
        return len(self._effects)
