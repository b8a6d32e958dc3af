"""Skin thickness: faces of the skin thicker or thinner by one factor, so both skins stiffer; web and ribs stay.

First order: K_skin grows by size / 100, f = -0.01 K_skin(mu) u.
"""

from collections.abc import Mapping

from femlib.arrays import FloatArray
from femlib.wing.effects.card import WingEffect
from femlib.wing.effects.response import Response
from femlib.wing.effects.skins import SkinEffect, SkinForces


def effect(response: Response) -> WingEffect:
    """Return the effect."""
    skins = SkinForces.of(response)

    def force(state: Mapping[str, float], load_factor: float, place: str) -> FloatArray:
        return -0.01 * load_factor * skins.of_state(state)

    return SkinEffect(
        name="skin_thickness",
        parameter="change of the thickness of the skins' faces",
        unit="%",
        bounds=(-90.0, 300.0),
        prior_sd=3.0,
        prior_source="fabric thickness and fibre content scatter by some per cent",
        separated_by="strain proportional to load hardly separates it from a modulus; coupons or a weighing do",
        words="thickness of the skins",
        action="correct the thickness of the skins in the twin",
        says=("their faces are {size} thicker than in the twin", "their faces are {size} thinner than in the twin"),
        seen_by=("deflection", "frequency"),
        load_power=1,
        response=response,
        force=force,
        skins=skins,
        factor=-0.01,
    )
