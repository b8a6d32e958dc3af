"""The response of the gauges to nodal forces in any state, without a factorisation per state.

With B the rows from displacements to gauge strains, K_0 the undamaged stiffness, Z = K_0^-1 B' and u = K_0^-1 f, the
strains of a damaged wing under forces f are (femlib.components, damage standing for forces, seen from the gauges)

    B u(mu) = Z' f + G(mu)' u_b + sum_i mu_i / (1 - mu_i) w_i(B)' u,   G(mu) = sum_i mu_i T_i z_b(mu),

exact to rounding. G belongs to a state and u to a force, so many forces in many states cost one solve per force and one
small system per state.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import scipy.sparse as sparse

from femlib.arrays import FloatArray
from femlib.components import damage_row
from femlib.components.structure import MOST_PORTS
from femlib.kept import Kept
from femlib.wing.model import MICRO, Wing

Key = tuple[float, ...]
Active = tuple[int, ...]


@dataclass(frozen=True, slots=True, eq=False)
class UndamagedResponse:
    """The response of the undamaged wing to one force.

    Attributes
    ----------
    active : tuple of int
        Components whose ports are known.
    gauges : FloatArray
        Gauge strains (n_gauges,) [-].
    ports : FloatArray
        Displacements at the ports (n_ports,).
    interior : FloatArray
        w_i(B)' u (n_active, n_gauges).
    """

    active: Active
    gauges: FloatArray
    ports: FloatArray
    interior: FloatArray


class Response:
    """The wing's responses, kept by state.

    Attributes
    ----------
    wing : Wing
        The model.
    """

    def __init__(self, wing: Wing) -> None:
        self.wing = wing
        self._shared: Kept[str, Any] = Kept()
        self._gauge_forces: Kept[Key, FloatArray] = Kept()
        self._moved: Kept[Key, FloatArray] = Kept()
        self._interior: Kept[int, sparse.csr_array] = Kept()
        self._undamaged: Kept[tuple[str, str, Active], UndamagedResponse] = Kept()

    def key(self, state: Mapping[str, float]) -> Key:
        """Return the damages of a state in the order of the wing's parameters, by which values of states are kept."""
        return tuple(damage_row(state, self.wing.parameters).tolist())

    def shared(self, name: str, make: Callable[[], Any]) -> Any:
        """Return an object that several effects share, made once for all of them."""
        return self._shared.get(name, make)

    def strains(self, state: Mapping[str, float], force: FloatArray) -> FloatArray:
        """Return the gauge strains (n_gauges,) [microstrain, compressive positive] under nodal forces (n_dofs,) [N]."""
        row = damage_row(state, self.wing.parameters)
        if not row.any():
            return np.asarray(MICRO * (force[self.wing.structure.supports.free] @ self.adjoint()))
        active = self.wing.structure.active(row[None, :])
        if self.wing.structure.n_ports(active) > MOST_PORTS:
            return np.asarray(MICRO * (self.wing.strain_rows @ self.moved_by(state, force)))
        return self._damaged(row, self._respond(force, active))

    def strains_of_fixed(self, state: Mapping[str, float], name: str, place: str, force: FloatArray) -> FloatArray:
        """Return `strains` for a force that is the same in every state, known by a name and a place: solved once."""
        row = damage_row(state, self.wing.parameters)
        active = self.wing.structure.active(row[None, :])
        if not row.any() or self.wing.structure.n_ports(active) > MOST_PORTS:
            return self.strains(state, force)
        undamaged = self._undamaged.get((name, place, active), lambda: self._respond(force, active))
        return self._damaged(row, undamaged)

    def lift_strains(self, state: Mapping[str, float]) -> FloatArray:
        """Return the gauge strains (n_gauges,) [microstrain] under the lift at load factor 1."""
        if not any(state.values()):
            return np.asarray(MICRO * (self.wing.strain_rows @ self.displacements({})))
        return self.strains_of_fixed(state, "lift", "", self.wing.lift)

    def displacements(self, state: Mapping[str, float]) -> FloatArray:
        """Return the displacements (n_dofs,) [m, rad] under the lift at load factor 1."""
        key = self.key(state)

        def moved() -> FloatArray:
            pristine = self.displacements({}) if any(key) else None
            return self.wing.structure.solve_loads(np.array(key), self.wing.lift, pristine)

        return self._moved.get(key, moved)

    def moved_by(self, state: Mapping[str, float], force: FloatArray) -> FloatArray:
        """Return the displacements (n_dofs, ...) under nodal forces (n_dofs, ...) [N]."""
        row = damage_row(state, self.wing.parameters)
        return self.wing.structure.solve_loads(row, force)

    def adjoint(self) -> FloatArray:
        """Return Z (n_free, n_gauges): the gauge strains per unit force on the undamaged wing's free motions."""
        structure = self.wing.structure
        return structure.adjoint(self.wing.strain_rows, structure.active(np.zeros((1, len(self.wing.parameters)))))

    def _respond(self, force: FloatArray, active: Active) -> UndamagedResponse:
        structure, rows = self.wing.structure, self.wing.strain_rows
        free = structure.supports.free
        factors = structure.eliminated(active).factors
        moved = factors.solve(force[free])
        interior = [self._interior_rows(k) @ moved for k in active]
        return UndamagedResponse(active, rows[:, free] @ moved, moved[factors.ports], np.array(interior))

    def _interior_rows(self, component: int) -> sparse.csr_array:
        """Return w_i(B)' (n_gauges, n_free): few gauges have anything inside a region."""

        def rows() -> sparse.csr_array:
            structure = self.wing.structure
            strains = self.wing.strain_rows[:, structure.supports.free].toarray().T
            return sparse.csr_array(structure.condensed[component].interior_load(strains).T)

        return self._interior.get(component, rows)

    def _damaged(self, row: FloatArray, undamaged: UndamagedResponse) -> FloatArray:
        damage = row[list(undamaged.active)]
        strains = undamaged.gauges + undamaged.ports @ self._forces(row, undamaged.active)
        return np.asarray(MICRO * (strains + (damage / (1.0 - damage)) @ undamaged.interior))

    def _forces(self, row: FloatArray, active: Active) -> FloatArray:
        """Return G (n_ports, n_gauges) in a state."""

        def forces() -> FloatArray:
            structure = self.wing.structure
            eliminated = structure.eliminated(active)
            load = eliminated.condensed_load(structure.adjoint(self.wing.strain_rows, active))
            return np.asarray(eliminated.ports.forces(row[None, list(active)], load)[0])

        return self._gauge_forces.get(tuple(row.tolist()), forces)
