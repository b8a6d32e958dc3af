"""A structure with damage components, solved exactly for any state and load."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
import scipy.sparse as sparse

from femlib.arrays import FloatArray, IntArray
from femlib.assembly import Shells, Supports, factorise
from femlib.assembly.factors import Factors
from femlib.components.output_map import OutputMap
from femlib.components.ports import Ports
from femlib.components.regions import Component, Condensed, checked_damage, condense, damage_row, refuse_overlap
from femlib.errors import InputError, frozen_floats
from femlib.mesh import DOFS_PER_NODE

MOST_PORTS = 1500
"""Beyond so many ports a factorisation a state is cheaper: 4,242 ports took 80 s to eliminate last."""


@dataclass(frozen=True, slots=True, eq=False)
class Eliminated:
    """The undamaged stiffness with some ports eliminated last.

    Attributes
    ----------
    factors : Factors
        Factors of the whole.
    ports : Ports
        Its condensation on the ports, and the components'.
    """

    factors: Factors
    ports: Ports

    def condensed_load(self, pristine: FloatArray) -> FloatArray:
        """Return S_0 u_0,b (n_ports, ...) of undamaged displacements (n_free, ...)."""
        return np.asarray(self.ports.schur @ pristine[self.factors.ports])


@dataclass(frozen=True, slots=True, eq=False)
class Adjoint:
    """The outputs per unit force on the undamaged structure.

    Attributes
    ----------
    rows : csr_array
        Map (n_outputs, n_dofs) from displacements to outputs.
    active : tuple of int
        Components whose ports the factors held.
    motion : FloatArray
        K_0^-1 rows' on the free degrees of freedom (n_free, n_outputs).
    """

    rows: sparse.csr_array
    active: tuple[int, ...]
    motion: FloatArray


class KeptFactors:
    """The factors that a structure was last solved with, the largest thing in memory; they change no result."""

    def __init__(self) -> None:
        self._eliminated: dict[tuple[int, ...], Eliminated] = {}
        self._adjoints: tuple[Adjoint, ...] = ()

    def __reduce__(self) -> tuple[type["KeptFactors"], tuple[()]]:
        """Leave the factors behind: another process makes its own when it needs them."""
        return KeptFactors, ()

    def eliminated(self, active: tuple[int, ...], make: Callable[[], Eliminated]) -> Eliminated:
        """Return the factors for the components `active`, one at a time."""
        found = self._eliminated.get(active)
        if found is None:
            self._eliminated.clear()
            found = self._eliminated[active] = make()
        return found

    def motion(self, rows: sparse.csr_array, active: tuple[int, ...], make: Callable[[], FloatArray]) -> FloatArray:
        """Return K_0^-1 rows' (n_free, n_outputs), two at a time, the newest last."""
        for kept in self._adjoints:
            if kept.rows is rows and kept.active == active:
                return kept.motion
        newest = Adjoint(rows, active, make())
        self._adjoints = (*self._adjoints[-1:], newest)
        return newest.motion


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
    _condensed: tuple[Condensed, ...] = field(init=False, repr=False)
    _kept: KeptFactors = field(init=False, repr=False, default_factory=KeptFactors)

    def __post_init__(self) -> None:
        if self.supports.n_dofs != self.shells.mesh.n_dofs:
            raise InputError(
                f"supports are of {self.supports.n_dofs} degrees of freedom but the mesh has "
                f"{self.shells.mesh.n_dofs}; expected those of this mesh; make them with Supports.holding"
            )
        refuse_overlap(self.components, self.shells.n_elements)
        condensed = tuple(condense(self.shells, self.supports, component) for component in self.components)
        object.__setattr__(self, "_condensed", condensed)

    @property
    def parameters(self) -> tuple[str, ...]:
        """Names of the damage parameters, in the order of the columns of a state array."""
        return tuple(component.parameter for component in self.components)

    @property
    def condensed(self) -> tuple[Condensed, ...]:
        """The components condensed on their ports."""
        return self._condensed

    def stiffness_left(self, damage: FloatArray) -> FloatArray:
        """Return the share of its stiffness that each part (n_parts,) keeps at damages (n_parameters,) in [0, 1)."""
        left = np.ones(self.shells.n_elements)
        for mu, component in zip(damage, self.components, strict=True):
            left[component.elements] = 1.0 - mu
        return left

    def left_in(self, state: Mapping[str, float]) -> FloatArray:
        """Return the same of a state of named damage fractions; InputError if a name or a damage is wrong."""
        row = damage_row(state, self.parameters)[None, :]
        return self.stiffness_left(checked_damage(row, self.parameters)[0])

    def reactions(self, moved: FloatArray, load: FloatArray, left: FloatArray) -> FloatArray:
        """Return the forces and moments (n_nodes, 6) [N, N m] of the supports, springs aside.

        `moved` are the displacements (n_dofs,) under the load (n_dofs,), `left` as `stiffness_left`.
        """
        held = self.shells.stiffness(factor=left) @ moved - load
        held[self.supports.free] = 0.0
        return held.reshape(-1, DOFS_PER_NODE)

    def active(self, damage: FloatArray) -> tuple[int, ...]:
        """Return the components whose ports to keep: all if few, so that one factorisation serves every state."""
        everything = tuple(range(len(self.components)))
        if self.n_ports(everything) <= MOST_PORTS:
            return everything
        return tuple(int(k) for k in np.flatnonzero(damage.any(axis=0)))

    def n_ports(self, active: tuple[int, ...]) -> int:
        """Return the number of port degrees of freedom of the components `active`."""
        return len(_all_ports([self._condensed[k] for k in active]))

    def eliminated(self, active: tuple[int, ...]) -> Eliminated:
        """Return the undamaged stiffness, factorised with the ports of the components `active` last."""
        return self._kept.eliminated(active, lambda: self._eliminate(active))

    def _eliminate(self, active: tuple[int, ...]) -> Eliminated:
        parts = [self._condensed[k] for k in active]
        ports = _all_ports(parts)
        factors = factorise(self.supports.reduce(self.shells.stiffness()), self.supports.groups, ports)
        losses = tuple((np.searchsorted(ports, part.ports), part.stiffness) for part in parts)
        return Eliminated(factors, Ports(factors.schur(), losses))

    def stiffness(self, damage: FloatArray) -> sparse.csc_array:
        """Return K(mu) (n_free, n_free), assembled: for checks and exports, not for solving many states."""
        matrix = self.supports.reduce(self.shells.stiffness())
        for mu, component in zip(damage, self.components, strict=True):
            matrix = matrix - mu * self.supports.reduce(self.shells.stiffness(component.elements))
        return sparse.csc_array(matrix)

    def solve(self, states: FloatArray, load: FloatArray) -> FloatArray:
        """Return the displacements (n_states, n_dofs) of damage states (n_states, n_parameters) under a load (n_dofs,).

        Raises
        ------
        InputError
            If a damage is outside [0, 1) or the load is not finite or of the wrong size.
        """
        damage = checked_damage(states, self.parameters)
        force = frozen_floats(load, "load", (self.supports.n_dofs,))[self.supports.free]
        active = self.active(damage)
        if self.n_ports(active) > MOST_PORTS:
            return np.stack([self._solve_directly(mu, force) for mu in damage])
        eliminated = self.eliminated(active)
        pristine = eliminated.factors.solve(force)
        extra = np.zeros((len(force), len(damage)))
        load_at_ports = eliminated.condensed_load(pristine)
        extra[eliminated.factors.ports] = eliminated.ports.forces(damage[:, list(active)], load_at_ports).T
        for k in active:
            extra += np.outer(self._condensed[k].interior_load(force), _ratio(damage[:, k]))
        moved = pristine[:, None] + eliminated.factors.solve(extra)
        return np.ascontiguousarray(self.supports.expand(moved).T)

    def solve_loads(self, damage: FloatArray, loads: FloatArray, pristine: FloatArray | None = None) -> FloatArray:
        """Return the displacements (n_dofs, ...) of one damage state (n_parameters,) under loads (n_dofs, ...).

        `pristine` (n_dofs, ...) are those of the undamaged structure; solved for if not given.

        Raises
        ------
        InputError
            If a damage is outside [0, 1) or a load is not finite or of the wrong size.
        """
        row = checked_damage(frozen_floats(damage, "damage", (len(self.parameters),))[None, :], self.parameters)
        shape = (self.supports.n_dofs, *np.shape(loads)[1:])
        force = frozen_floats(loads, "loads", shape)[self.supports.free]
        if pristine is not None:
            pristine = frozen_floats(pristine, "pristine", shape)
        active = self.active(row)
        if self.n_ports(active) > MOST_PORTS:
            return self._solve_directly(row[0], force)
        eliminated = self.eliminated(active)
        moved = eliminated.factors.solve(force) if pristine is None else pristine[self.supports.free]
        if row.any():
            extra = np.zeros_like(force)
            load_at_ports = eliminated.condensed_load(moved)
            extra[eliminated.factors.ports] = eliminated.ports.forces(row[:, list(active)], load_at_ports)[0]
            for k in active:
                extra += float(_ratio(row[0, k])) * self._condensed[k].interior_load(force)
            moved += eliminated.factors.solve(extra)
        return self.supports.expand(moved)

    def solve_outputs(self, states: FloatArray, load: FloatArray, rows: sparse.csr_array) -> FloatArray:
        """Return rows @ u (n_states, n_outputs) for rows (n_outputs, n_dofs), without forming u; arguments as `solve`.

        The work of a state is the dense solve at the ports: one adjoint solve per output gives it for any force.
        """
        damage = checked_damage(states, self.parameters)
        checked_rows(rows, self.supports.n_dofs)
        active = self.active(damage)
        if self.n_ports(active) > MOST_PORTS:
            return np.asarray((rows @ self.solve(states, load).T).T)
        return self.output_map(load, rows, active).solve(damage)

    def output_map(self, load: FloatArray, rows: sparse.csr_array, active: tuple[int, ...]) -> OutputMap:
        """Return the map from states that damage the components `active` alone to rows @ u under a load (n_dofs,).

        Raises
        ------
        InputError
            If the load is not finite or of the wrong size.
        """
        force = frozen_floats(load, "load", (self.supports.n_dofs,))[self.supports.free]
        checked_rows(rows, self.supports.n_dofs)
        eliminated = self.eliminated(active)
        ports = eliminated.factors.ports
        pristine = eliminated.factors.solve(force)
        adjoint = self.adjoint(rows, active)
        interior = [self._condensed[k].interior_load(force) @ adjoint for k in active]
        return OutputMap(
            self.parameters,
            active,
            sparse.csr_array(rows)[:, self.supports.free] @ pristine,
            eliminated.ports,
            eliminated.condensed_load(pristine),
            adjoint[ports],
            np.array(interior).reshape(len(active), adjoint.shape[1]),
        )

    def adjoint(self, rows: sparse.csr_array, active: tuple[int, ...]) -> FloatArray:
        """Return K_0^-1 rows' (n_free, n_outputs): one solve per output, kept while the same rows are asked for."""
        return self._kept.motion(rows, active, lambda: self._solve_adjoint(rows, active))

    def _solve_adjoint(self, rows: sparse.csr_array, active: tuple[int, ...]) -> FloatArray:
        free_rows = sparse.csr_array(rows)[:, self.supports.free]
        return np.asarray(self.eliminated(active).factors.solve(free_rows.toarray().T))

    def _solve_directly(self, mu: FloatArray, force: FloatArray) -> FloatArray:
        """Return the displacements (n_dofs,) of one state from a factorisation of its own."""
        moved = factorise(self.stiffness(mu), self.supports.groups).solve(force)
        return self.supports.expand(moved)


def checked_rows(rows: sparse.csr_array, n_dofs: int) -> None:
    """Raise InputError if rows do not map displacements."""
    shape = tuple(rows.shape)
    if len(shape) != 2 or shape[1] != n_dofs:
        raise InputError(
            f"rows have shape {shape}; expected ('n', {n_dofs}), one column for each degree of freedom; make "
            "them of this mesh"
        )


def _all_ports(condensed: Sequence[Condensed]) -> IntArray:
    return np.unique(np.concatenate([*(c.ports for c in condensed), np.zeros(0, dtype=np.int64)]))


def _ratio(mu: FloatArray) -> FloatArray:
    """Return mu / (1 - mu)."""
    return np.asarray(mu / (1.0 - mu))
