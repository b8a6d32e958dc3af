"""Effective damage regions: patches of skin whose stiffness falls by the factor 1 - mu."""

from dataclasses import dataclass

import numpy as np

from femlib.arrays import BoolArray, FloatArray
from femlib.errors import InputError


@dataclass(frozen=True, slots=True)
class DamageRegion:
    """A rectangle in span and chord fractions on the top skin.

    Attributes
    ----------
    name : str
        Name of the region, "R1".
    parameter : str
        Name of its damage parameter in a state, "mu1".
    eta_min, eta_max, chord_min, chord_max : float
        Edges as span and chord fractions; the mesh has grid lines there.
    """

    name: str
    parameter: str
    eta_min: float
    eta_max: float
    chord_min: float
    chord_max: float

    def __post_init__(self) -> None:
        inside = 0.0 <= self.eta_min < self.eta_max <= 1.0 and 0.0 <= self.chord_min < self.chord_max <= 1.0
        if not inside:
            raise InputError(
                f"damage region {self.name} has eta {self.eta_min} to {self.eta_max} and x/c {self.chord_min} to "
                f"{self.chord_max}; expected increasing edges between 0 and 1; move it onto the wing"
            )

    def contains(self, eta: FloatArray, chord: FloatArray) -> BoolArray:
        """Return whether points lie inside or on the edge."""
        within = (self.eta_min <= eta) & (eta <= self.eta_max)
        return np.asarray(within & (self.chord_min <= chord) & (chord <= self.chord_max))


UAV_REGIONS = (
    DamageRegion("R1", "mu1", 0.24, 0.39, 0.345, 0.55),
    DamageRegion("R2", "mu2", 0.67, 0.83, 0.345, 0.43),
)
"""The two regions of the study, on the top skin aft of the spar. Fitted to the published damage increments."""
