"""The share of the inner forces that both skins carry."""

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
import scipy.sparse as sparse

from femlib.arrays import FloatArray
from femlib.wing.effects.response import Response


@dataclass(frozen=True, slots=True, eq=False)
class SkinForces:
    """Nodal forces of the skins by state.

    Attributes
    ----------
    response : Response
        The wing's displacements.
    """

    response: Response
    _matrices: dict[str, sparse.csc_array] = field(init=False, repr=False, default_factory=dict)

    def of_state(self, state: Mapping[str, float]) -> FloatArray:
        """Return K_skin(mu) u (n_dofs,) [N, N m] at load factor 1."""
        wing = self.response.wing
        shells, patches = wing.structure.shells, wing.structure.shells.mesh.patches
        skin = shells.section == 0
        if not self._matrices:  # made at the first call: two seconds that many users of the wing never need
            plain = skin & np.isin(shells.mesh.patch_of_element, [patches.index("top"), patches.index("bottom")])
            self._matrices[""] = shells.stiffness(plain)
            for component in wing.structure.components:
                self._matrices[component.parameter] = shells.stiffness(component.elements & skin)
        u = self.response.displacements(state)
        pull = self._matrices[""] @ u
        for component in wing.structure.components:
            left = 1.0 - state.get(component.parameter, 0.0)
            pull = pull + left * (self._matrices[component.parameter] @ u)
        return np.asarray(pull)
