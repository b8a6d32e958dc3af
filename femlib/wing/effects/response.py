"""How the gauges answer nodal forces in a state: one adjoint solution a gauge, kept for all effects.

With B the rows from displacements to gauge strains and K(mu) the stiffness, Z = K(mu)^-1 B^T gives the strains under
any forces f as Z^T f. A state costs one factorisation; every effect after that is a product.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from scipy.sparse.linalg import SuperLU, splu

from femlib.arrays import FloatArray
from femlib.components import damage_row
from femlib.wing.model import MICRO, Wing


@dataclass(frozen=True, slots=True, eq=False)
class Response:
    """The adjoint solutions of a wing by state.

    Attributes
    ----------
    wing : Wing
        The model.
    """

    wing: Wing
    _adjoint: dict[tuple[float, ...], FloatArray] = field(init=False, repr=False, default_factory=dict)
    _moved: dict[tuple[float, ...], FloatArray] = field(init=False, repr=False, default_factory=dict)
    _factor: dict[tuple[float, ...], SuperLU] = field(init=False, repr=False, default_factory=dict)

    def strains(self, state: Mapping[str, float], force: FloatArray) -> FloatArray:
        """Return the gauge strains (n_gauges,) [microstrain, compressive positive] under nodal forces (n_dofs,) [N]."""
        return np.asarray(MICRO * (force @ self._of_state(state)))

    def displacements(self, state: Mapping[str, float]) -> FloatArray:
        """Return the displacements (n_dofs,) [m, rad] under the lift at load factor 1."""
        key = tuple(damage_row(state, self.wing.parameters).tolist())
        if key not in self._moved:
            self._moved[key] = self.wing.solve(state, 1.0).ravel()
        return self._moved[key]

    def moved_by(self, state: Mapping[str, float], force: FloatArray) -> FloatArray:
        """Return the displacements (n_dofs, ...) under nodal forces (n_dofs, ...) [N]."""
        supports = self.wing.structure.supports
        return supports.expand(self._factors(damage_row(state, self.wing.parameters)).solve(force[supports.free]))

    def _of_state(self, state: Mapping[str, float]) -> FloatArray:
        row = damage_row(state, self.wing.parameters)
        key = tuple(row.tolist())
        if key not in self._adjoint:
            supports = self.wing.structure.supports
            rows = self.wing.strain_rows[:, supports.free].T.toarray()
            self._adjoint[key] = supports.expand(self._factors(row).solve(rows))
        return self._adjoint[key]

    def _factors(self, row: FloatArray) -> SuperLU:
        key = tuple(row.tolist())
        if key not in self._factor:
            self._factor.clear()  # one at a time: factors are the largest thing in memory
            self._factor[key] = splu(
                self.wing.structure.stiffness(row),
                permc_spec="MMD_AT_PLUS_A",
                diag_pivot_thresh=0.0,
                options={"SymmetricMode": True},
            )
        return self._factor[key]
