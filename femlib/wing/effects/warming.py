"""Thermal forces of a damaged wing."""

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from femlib.arrays import BoolArray, FloatArray
from femlib.assembly import thermal_load
from femlib.wing.model import Wing


@dataclass(frozen=True, slots=True, eq=False)
class WarmWing:
    """A wing with a temperature field.

    Attributes
    ----------
    wing : Wing
        The model.
    warming : FloatArray
        Temperature of each element (n_elements,) per unit of size [K].
    """

    wing: Wing
    warming: FloatArray
    _parts: dict[str, FloatArray] = field(init=False, repr=False, default_factory=dict)

    def force(self, state: Mapping[str, float]) -> FloatArray:
        """Return nodal forces (n_dofs,) [N] in a state: damaged skin pushes less."""
        if not self._parts:  # made at the first call: two seconds that many users of the wing never need
            self._parts[""] = self._load(np.ones(len(self.warming), dtype=bool))
            for component in self.wing.structure.components:
                self._parts[component.parameter] = self._load(component.elements)
        total = self._parts[""].copy()
        for parameter, damage in state.items():
            total -= damage * self._parts[parameter]
        return total

    def _load(self, elements: BoolArray) -> FloatArray:
        shells = self.wing.structure.shells
        return np.asarray(thermal_load(shells, np.where(elements, self.warming, 0.0), np.zeros(len(self.warming))))
