"""Temperature difference of the skins: the upper skin warmer than the lower one, as under the sun."""

from collections.abc import Mapping

import numpy as np

from femlib.arrays import FloatArray
from femlib.wing.effects.card import WingEffect
from femlib.wing.effects.response import Response
from femlib.wing.effects.thermal.warming import WarmEffect, WarmWing


def effect(response: Response) -> WingEffect:
    """Return the effect: half the difference above, half below zero, web and ribs between."""
    wing = response.wing
    mesh = wing.structure.shells.mesh
    patch = mesh.patch_of_element
    upper = np.isin(patch, [k for k, name in enumerate(mesh.patches) if name not in ("bottom", "web", "ribs")])
    lower = patch == mesh.patches.index("bottom")
    warm = WarmWing(wing, 0.5 * upper - 0.5 * lower)

    def force(state: Mapping[str, float], load_factor: float, place: str) -> FloatArray:
        return warm.force(state)

    return WarmEffect(
        name="temperature_gradient",
        parameter="temperature of the upper skin above the lower one",
        unit="K",
        prior_sd=5.0,
        bounds=(-40.0, 40.0),
        prior_source="sun on a dark skin warms it by five to twenty kelvin",
        separated_by="moisture of one skin gives the same readings; a thermometer on each skin separates them",
        words="difference in temperature of the skins",
        action="correct the readings for the difference in temperature of the skins",
        says=(
            "the upper skin is {size} warmer than the lower one",
            "the upper skin is {size} colder than the lower one",
        ),
        seen_by=("thermal_zero",),
        load_power=0,
        response=response,
        force=force,
        warm=warm,
    )
