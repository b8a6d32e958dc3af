"""Uniform temperature: the whole wing warmer than when the gauges were set to zero.

Skin and wood expand differently, so the readings are nearly, not quite, the same everywhere. Damaged skin pushes less:
its thermal force falls with its stiffness.
"""

from collections.abc import Mapping

import numpy as np

from femlib.arrays import FloatArray
from femlib.wing.effects.card import WingEffect
from femlib.wing.effects.response import Response
from femlib.wing.effects.thermal.warming import WarmEffect, WarmWing


def effect(response: Response) -> WingEffect:
    """Return the effect."""
    wing = response.wing
    warm = WarmWing(wing, np.ones(wing.structure.shells.mesh.n_elements))

    def force(state: Mapping[str, float], load_factor: float, place: str) -> FloatArray:
        return warm.force(state)

    return WarmEffect(
        name="temperature_uniform",
        parameter="temperature above that at which the gauges were set to zero",
        unit="K",
        prior_sd=10.0,
        bounds=(-100.0, 100.0),
        prior_source="a flight or a day in a hangar changes the temperature by ten to thirty kelvin",
        separated_by="it is there at zero load and does not grow with the load",
        words="temperature of the whole wing",
        action="correct the readings for the temperature of the wing",
        says=(
            "the wing is {size} warmer than when the gauges were set to zero",
            "the wing is {size} colder than when the gauges were set to zero",
        ),
        seen_by=("thermal_zero",),
        load_power=0,
        response=response,
        force=force,
        warm=warm,
    )
