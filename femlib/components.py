"""Damage as components: a stiffness that is affine in the damage parameters, solved exactly from one factorisation.

    K(mu) = K_0 - sum_i mu_i K_i,

K_i being the stiffness of region i. A region's nodes are its ports b, shared with the rest of the structure, and its
interior nodes i. Inside the region every stiffness scales by 1 - mu, so its condensation on the ports scales too:

    T_i = K_bb - K_bi K_ii^-1 K_ib   (region alone),   S(mu) = S_0 - sum_i mu_i T_i,   S(mu) u_b = S_0 u_0,b,

S_0 being the undamaged structure condensed on all ports and u_0 its solution: the condensed load does not depend on
mu. The whole solution follows from forces that stand for the damage,

    u = K_0^-1 (f + w),   w_b = mu T_i u_b + mu / (1 - mu) K_bi K_ii^-1 f_i,   w_i = mu / (1 - mu) f_i.

Source: R. J. Guyan, AIAA Journal 3 (1965) 380 (static condensation); D. B. P. Huynh, D. J. Knezevic, A. T. Patera,
ESAIM M2AN 47 (2013) 213-251 (components with ports). The result is the full model's to rounding; a state costs one
dense solve of the size of the ports.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
import scipy.linalg as linalg
import scipy.sparse as sparse

from femlib.arrays import BoolArray, FloatArray, IntArray
from femlib.assembly import Factors, Shells, Supports, factorise
from femlib.errors import InputError, frozen_floats


@dataclass(frozen=True, slots=True, eq=False)
class Component:
    """One region whose stiffness falls with its parameter.

    Attributes
    ----------
    name, parameter : str
        Names of the region and of its damage parameter.
    elements : BoolArray
        Which elements belong to it (n_elements,).
    """

    name: str
    parameter: str
    elements: BoolArray


@dataclass(frozen=True, slots=True, eq=False)
class Condensed:
    """A region condensed on its ports, in numbers of the free degrees of freedom.

    Attributes
    ----------
    ports, interior : IntArray
        Free degrees of freedom shared with the rest (n_ports,), and the region's own (n_interior,).
    stiffness : FloatArray
        T (n_ports, n_ports) of the module's docstring.
    carry : FloatArray
        K_bi K_ii^-1 (n_ports, n_interior): from interior loads to port forces.
    """

    ports: IntArray
    interior: IntArray
    stiffness: FloatArray
    carry: FloatArray

    def interior_load(self, force: FloatArray) -> FloatArray:
        """Return the forces (n_free,) that stand for the interior loads: w at mu / (1 - mu) = 1 without its T term."""
        stand_in = np.zeros_like(force)
        stand_in[self.interior] = force[self.interior]
        stand_in[self.ports] = self.carry @ force[self.interior]
        return stand_in


@dataclass(frozen=True, slots=True, eq=False)
class DamagedStructure:
    """A supported structure with damage components, ready to be solved for any state and load.

    Attributes
    ----------
    shells : Shells
        The undamaged structure.
    supports : Supports
        What is held.
    components : tuple of Component
        Damage regions; their elements must not overlap.

    Raises
    ------
    InputError
        If a region is empty or two regions share an element.
    """

    shells: Shells
    supports: Supports
    components: tuple[Component, ...]
    _factors: Factors = field(init=False, repr=False)
    _condensed: tuple[Condensed, ...] = field(init=False, repr=False)
    _schur: FloatArray = field(init=False, repr=False)

    def __post_init__(self) -> None:
        _refuse_overlap(self.components)
        condensed = tuple(self._condense(component) for component in self.components)
        ports = np.unique(np.concatenate([*(c.ports for c in condensed), np.zeros(0, dtype=np.int64)]))
        factors = factorise(self.supports.reduce(self.shells.stiffness()), self.supports.groups, ports)
        for name, value in (("_condensed", condensed), ("_factors", factors), ("_schur", factors.schur())):
            object.__setattr__(self, name, value)

    @property
    def parameters(self) -> tuple[str, ...]:
        """Names of the damage parameters, in the order of the columns of a state array."""
        return tuple(component.parameter for component in self.components)

    @property
    def n_ports(self) -> int:
        """Number of port degrees of freedom of all components."""
        return len(self._factors.ports)

    @property
    def condensed_stiffness(self) -> FloatArray:
        """Undamaged stiffness condensed on the ports (n_ports, n_ports)."""
        return self._schur

    def stiffness(self, damage: FloatArray) -> sparse.csc_array:
        """Return K(mu) (n_free, n_free), assembled: for checks and exports, not for solving many states."""
        matrix = self.supports.reduce(self.shells.stiffness())
        for mu, component in zip(damage, self.components, strict=True):
            matrix = matrix - mu * self.supports.reduce(self.shells.stiffness(component.elements))
        return sparse.csc_array(matrix)

    def solve(self, states: FloatArray, load: FloatArray) -> FloatArray:
        """Return the displacements (n_states, n_dofs) of damage states (n_states, n_parameters) under a load (n_dofs,)
        [N].

        Raises
        ------
        InputError
            If a damage is outside [0, 1) or the load is not finite or of the wrong size.
        """
        damage, force, pristine = self._at_rest(states, load)
        extra = np.zeros((len(force), len(damage)))
        extra[self._factors.ports] = self._port_forces(damage, pristine).T
        for ratio, condensed in zip(_ratios(damage), self._condensed, strict=True):
            extra += np.outer(condensed.interior_load(force), ratio)
        moved = pristine[:, None] + self._factors.solve(extra)
        return np.ascontiguousarray(self.supports.expand(moved).T)

    def solve_outputs(self, states: FloatArray, load: FloatArray, rows: sparse.csr_array) -> FloatArray:
        """Return rows @ u (n_states, n_outputs) for rows (n_outputs, n_dofs), without forming u; arguments as `solve`.

        The work of a state is the dense solve at the ports: one adjoint solve an output tells what forces do to it.
        """
        damage, force, pristine = self._at_rest(states, load)
        free_rows = sparse.csr_array(rows)[:, self.supports.free]
        adjoint = self._factors.solve(free_rows.toarray().T)
        outputs = free_rows @ pristine + self._port_forces(damage, pristine) @ adjoint[self._factors.ports]
        for ratio, condensed in zip(_ratios(damage), self._condensed, strict=True):
            outputs += np.outer(ratio, condensed.interior_load(force) @ adjoint)
        return np.asarray(outputs)

    def _at_rest(self, states: FloatArray, load: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return the checked states, the free loads (n_free,) and the undamaged displacements (n_free,)."""
        damage = checked_damage(states, self.parameters)
        force = frozen_floats(load, "load", (self.supports.n_dofs,))[self.supports.free]
        return damage, force, self._factors.solve(force)

    def _port_forces(self, damage: FloatArray, pristine: FloatArray) -> FloatArray:
        """Return sum_i mu_i T_i u_b of the module's docstring for each state (n_states, n_ports)."""
        ports = self._factors.ports
        condensed_load = self._schur @ pristine[ports]
        places = [np.searchsorted(ports, c.ports) for c in self._condensed]
        forces = np.zeros((len(damage), len(ports)))
        for mu, force in zip(damage, forces, strict=True):
            if not mu.any():
                continue
            loss = np.zeros_like(self._schur)
            for amount, place, condensed in zip(mu, places, self._condensed, strict=True):
                loss[np.ix_(place, place)] += amount * condensed.stiffness
            force[:] = loss @ linalg.solve(self._schur - loss, condensed_load, assume_a="pos")
        return forces

    def _condense(self, component: Component) -> Condensed:
        stiffness = self.supports.reduce(self.shells.stiffness(component.elements))
        rest = self.supports.reduce(self.shells.stiffness(~component.elements))
        own = np.flatnonzero(np.diff(stiffness.indptr))
        is_port = np.diff(rest.indptr)[own] > 0
        ports, interior = own[is_port], own[~is_port]
        block = stiffness[own][:, own].toarray()
        across = block[np.ix_(is_port, ~is_port)]
        carry = linalg.solve(block[np.ix_(~is_port, ~is_port)], across.T, assume_a="pos").T
        return Condensed(ports, interior, block[np.ix_(is_port, is_port)] - carry @ across.T, carry)


def _ratios(damage: FloatArray) -> FloatArray:
    """Return mu / (1 - mu) of each component and state (n_components, n_states)."""
    return np.asarray((damage / (1.0 - damage)).T)


def damage_row(state: Mapping[str, float], parameters: Sequence[str]) -> FloatArray:
    """Return a named state as a row (n_parameters,); parameters that the state does not name are undamaged.

    Raises
    ------
    InputError
        If the state names an unknown parameter.
    """
    unknown = sorted(set(state) - set(parameters))
    if unknown:
        raise InputError(f"state names {unknown}; expected among {list(parameters)}; correct the parameter's name")
    return np.array([float(state.get(name, 0.0)) for name in parameters])


def checked_damage(states: FloatArray, parameters: Sequence[str]) -> FloatArray:
    """Return states (n_states, n_parameters) as floats after checking that every damage lies in [0, 1)."""
    damage = frozen_floats(states, "states", (-1, len(parameters)))
    bad = (damage < 0.0) | (damage >= 1.0)
    if bad.any():
        row, column = (int(k) for k in np.argwhere(bad)[0])
        raise InputError(
            f"state {row} has {parameters[column]} = {damage[row, column]:g}; expected a loss of stiffness from 0 to "
            "below 1 (a loss of 1 leaves a mechanism); give it as a fraction, not in percent"
        )
    return damage


def _refuse_overlap(components: Sequence[Component]) -> None:
    for k, second in enumerate(components):
        if not second.elements.any():
            raise InputError(f"region {second.name} holds no element; expected at least one; move it onto the mesh")
        for first in components[:k]:
            shared = int(np.sum(first.elements & second.elements))
            if shared:
                raise InputError(
                    f"regions {first.name} and {second.name} share {shared} elements; "
                    "expected none; move their edges apart"
                )
