"""A quantity that depends on parameters: its value and its slopes."""

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
import scipy.sparse as sparse

from femlib.arrays import FloatArray
from femlib.errors import InputError


@dataclass(frozen=True, slots=True, eq=False)
class Varying:
    """An array and its derivative by each parameter that it depends on.

    Attributes
    ----------
    value : FloatArray
        The array, of any shape.
    slopes : mapping
        Derivatives, of the same shape, by parameter name; a parameter that is not named does not change it.
    """

    value: FloatArray
    slopes: Mapping[str, FloatArray] = field(default_factory=dict)

    def __post_init__(self) -> None:
        for name, slope in self.slopes.items():
            if np.shape(slope) != np.shape(self.value):
                raise InputError(
                    f"slope by {name} has shape {np.shape(slope)}; expected {np.shape(self.value)}, that of the "
                    "value; give one entry for each"
                )

    def __mul__(self, other: "Varying") -> "Varying":
        """Return the product entry by entry, by the product rule."""
        names = [*self.slopes, *(name for name in other.slopes if name not in self.slopes)]
        nothing = np.zeros_like(self.value)
        slopes = {
            name: self.slopes.get(name, nothing) * other.value + self.value * other.slopes.get(name, nothing)
            for name in names
        }
        return Varying(self.value * other.value, slopes)


@dataclass(frozen=True, slots=True, eq=False)
class VaryingRows:
    """Rows that map displacements to outputs, and their derivatives.

    Attributes
    ----------
    value : csr_array
        Map (n_outputs, n_dofs).
    slopes : mapping
        Derivatives (n_outputs, n_dofs) by parameter name, as that of a gauge's strain by its place.
    """

    value: sparse.csr_array
    slopes: Mapping[str, sparse.csr_array] = field(default_factory=dict)

    def __post_init__(self) -> None:
        for name, slope in self.slopes.items():
            if slope.shape != self.value.shape:
                raise InputError(
                    f"slope by {name} has shape {slope.shape}; expected {self.value.shape}, that of the rows; make it "
                    "of the same mesh"
                )
