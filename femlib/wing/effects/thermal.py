"""Effects of temperature: the whole wing warmer than when its gauges were zeroed, or one skin warmer than the other.

Skin and wood expand differently, so the readings of a warmer wing are nearly, not quite, the same everywhere. Damaged
skin pushes less: its thermal force falls with its stiffness.
"""

from collections.abc import Mapping
from functools import cache
from typing import Any

import numpy as np

from femlib.arrays import BoolArray, FloatArray
from femlib.assembly import thermal_load
from femlib.wing.effects.card import WingEffect
from femlib.wing.effects.response import Response


def temperature_uniform(response: Response) -> WingEffect:
    """Return the effect of a warmer wing."""
    return _warm_effect(
        response,
        np.ones(response.wing.structure.shells.mesh.n_elements),
        name="temperature_uniform",
        parameter="temperature above that at which the gauges were set to zero",
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
    )


def temperature_gradient(response: Response) -> WingEffect:
    """Return the effect of sun on the upper skin: half the difference above zero, half below, web and ribs between."""
    mesh = response.wing.structure.shells.mesh
    patch = mesh.patch_of_element
    upper = np.isin(patch, [k for k, name in enumerate(mesh.patches) if name not in ("bottom", "web", "ribs")])
    lower = patch == mesh.patches.index("bottom")
    return _warm_effect(
        response,
        0.5 * upper - 0.5 * lower,
        name="temperature_gradient",
        parameter="temperature of the upper skin above the lower one",
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
    )


def _warm_effect(response: Response, warming: FloatArray, **card: Any) -> WingEffect:
    """Return the effect of a temperature of each element (n_elements,) per unit of size [K]; it needs no load.

    Its parts are fixed forces, each solved once for all states.
    """
    shells, components = response.wing.structure.shells, response.wing.structure.components

    def load(elements: BoolArray) -> FloatArray:
        return thermal_load(shells, np.where(elements, warming, 0.0), np.zeros(len(warming)))

    @cache  # made at the first call: a second that many users of the wing never need
    def forces() -> dict[str, FloatArray]:
        return {"": load(np.ones(len(warming), dtype=bool))} | {own.parameter: load(own.elements) for own in components}

    def strains(state: Mapping[str, float], load_factor: float, place: str, time: float) -> FloatArray:
        shares = {"": 1.0} | {parameter: -damage for parameter, damage in state.items() if damage}
        found = [s * response.strains_of_fixed(state, card["name"], p, forces()[p]) for p, s in shares.items()]
        return np.asarray(np.sum(found, axis=0))

    return WingEffect(
        unit="K",
        load_power=0,
        strains=strains,
        **card,
    )
