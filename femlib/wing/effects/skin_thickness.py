"""Skin thickness: faces of the skin thicker or thinner by one factor, so both skins stiffer; web and ribs stay.

First order: K_skin grows by size / 100, f = -0.01 K_skin(mu) u.
"""

from collections.abc import Mapping

import numpy as np

from femlib.arrays import FloatArray
from femlib.wing.effects.card import WingEffect
from femlib.wing.effects.response import Response


def effect(response: Response) -> WingEffect:
    """Return the effect."""
    wing = response.wing
    shells = wing.structure.shells
    names = ("top", "bottom")
    skins = shells.stiffness(np.isin(shells.mesh.patch_of_element, [shells.mesh.patches.index(p) for p in names]))
    damaged = {c.parameter: shells.stiffness(c.elements) for c in wing.structure.components}

    def force(state: Mapping[str, float], load_factor: float, place: str) -> FloatArray:
        u = load_factor * response.displacements(state)
        pull = skins @ u
        for parameter, matrix in damaged.items():
            pull = pull + (1.0 - state.get(parameter, 0.0)) * (matrix @ u)
        return np.asarray(-0.01 * pull)

    return WingEffect(
        name="skin_thickness",
        parameter="change of the thickness of the skins' faces",
        unit="%",
        prior_sd=3.0,
        prior_source="fabric thickness and fibre content scatter by some per cent",
        separated_by="strain proportional to load hardly tells it from a modulus; coupons or a weighing do",
        load_power=1,
        response=response,
        force=force,
    )
