"""Thermal forces of a damaged wing, and effects that are such forces."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from femlib.arrays import BoolArray, FloatArray
from femlib.assembly import thermal_load
from femlib.wing.effects.card import WingEffect
from femlib.wing.model import Wing


class WarmWing:
    """A wing with a temperature field; its forces are kept.

    Attributes
    ----------
    wing : Wing
        The model.
    warming : FloatArray
        Temperature of each element (n_elements,) per unit of size [K].
    """

    def __init__(self, wing: Wing, warming: FloatArray) -> None:
        self.wing = wing
        self.warming = warming

    @cached_property
    def parts(self) -> Mapping[str, FloatArray]:
        """Nodal forces (n_dofs,) [N] of the undamaged wing, named "", and of each region by parameter.

        Made at the first call: a second that many users of the wing never need.
        """
        own = {part.parameter: self._load(part.elements) for part in self.wing.structure.components}
        return {"": self._load(np.ones(len(self.warming), dtype=bool))} | own

    def force(self, state: Mapping[str, float]) -> FloatArray:
        """Return nodal forces (n_dofs,) [N] in a state: damaged skin pushes less."""
        parts = self.parts
        return np.asarray(parts[""] - sum(damage * parts[parameter] for parameter, damage in state.items()))

    def _load(self, elements: BoolArray) -> FloatArray:
        shells = self.wing.structure.shells
        return np.asarray(thermal_load(shells, np.where(elements, self.warming, 0.0), np.zeros(len(self.warming))))


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class WarmEffect(WingEffect):
    """An effect that is a temperature field: its parts are fixed forces, so each is solved once for all states.

    Attributes
    ----------
    warm : WarmWing
        The wing with the field of a unit of size.
    """

    warm: WarmWing

    def signature(
        self, twin: Any, state: Mapping[str, float], load_factor: float, place: str = "", time: float = 0.0
    ) -> FloatArray:
        """Return the change of the gauge strains (n_gauges,) in microstrain per unit of size."""
        shares = {"": 1.0} | {parameter: -damage for parameter, damage in state.items() if damage}
        parts = self.warm.parts
        strains = [s * self.response.strains_of_fixed(state, self.name, p, parts[p]) for p, s in shares.items()]
        return np.asarray(np.sum(strains, axis=0))
