"""Effects of temperature: the whole wing warmer than when its gauges were zeroed, or one skin warmer than the other.

Skin and wood expand differently, so the readings of a warmer wing are nearly, not quite, the same everywhere. Damaged
skin pushes less: its thermal force falls with its stiffness.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from femlib.arrays import BoolArray, FloatArray
from femlib.assembly import thermal_load
from femlib.wing.effects.card import WingEffect
from femlib.wing.effects.response import Response
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
    """Return the effect of a temperature of each element (n_elements,) per unit of size [K]; it needs no load."""
    warm = WarmWing(response.wing, warming)
    return WarmEffect(
        unit="K",
        load_power=0,
        response=response,
        force=lambda state, load_factor, place: warm.force(state),
        warm=warm,
        **card,
    )
