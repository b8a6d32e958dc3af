"""The share of the inner forces that both skins carry, and effects that are a part of it."""

from collections.abc import Mapping
from functools import cached_property

import numpy as np
import scipy.sparse as sparse

from femlib.arrays import FloatArray
from femlib.kept import Kept
from femlib.wing.effects.card import WingEffect
from femlib.wing.effects.response import Response


class SkinForces:
    """Nodal forces of the skins by state; what they strain is kept.

    Attributes
    ----------
    response : Response
        The wing's displacements.
    """

    def __init__(self, response: Response) -> None:
        self.response = response
        self._strains: Kept[tuple[float, ...], FloatArray] = Kept()

    @classmethod
    def of(cls, response: Response) -> "SkinForces":
        """Return the forces of a response, one for all effects that ask."""
        found: SkinForces = response.shared("skins", lambda: cls(response))
        return found

    def strains(self, state: Mapping[str, float]) -> FloatArray:
        """Return the gauge strains (n_gauges,) [microstrain] under `of_state`, solved once per state."""
        return self._strains.get(self.response.key(state), lambda: self.response.strains(state, self.of_state(state)))

    def of_state(self, state: Mapping[str, float]) -> FloatArray:
        """Return K_skin(mu) u (n_dofs,) [N, N m] at load factor 1."""
        wing = self.response.wing
        u = self.response.displacements(state)
        pull = self._matrices[""] @ u
        for component in wing.structure.components:
            left = 1.0 - state.get(component.parameter, 0.0)
            pull = pull + left * (self._matrices[component.parameter] @ u)
        return np.asarray(pull)

    @cached_property
    def _matrices(self) -> Mapping[str, sparse.csc_array]:
        """Stiffness of the skins outside the regions, named "", and in each; two seconds that many never need."""
        structure = self.response.wing.structure
        shells, patches = structure.shells, structure.shells.mesh.patches
        skin = shells.section == 0
        plain = skin & np.isin(shells.mesh.patch_of_element, [patches.index("top"), patches.index("bottom")])
        own = {part.parameter: shells.stiffness(part.elements & skin) for part in structure.components}
        return {"": shells.stiffness(plain)} | own


def skin_thickness(response: Response) -> WingEffect:
    """Return the effect of faces of both skins thicker or thinner by one factor; web and ribs stay.

    First order: K_skin grows by size / 100, f = -0.01 K_skin(mu) u.
    """
    skins = SkinForces.of(response)
    return WingEffect(
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
        strains=lambda state, load_factor, place, time: -0.01 * load_factor * skins.strains(state),
    )
