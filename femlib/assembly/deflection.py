"""Large deflection: the displacements and rotations at which the shells' forces balance the loads.

    r(u, R) = load fraction * f - sum over elements of their corotated forces = 0,

by Newton's method, the loads keeping their directions. A fraction of the load that does not converge is halved.
Source: M. A. Crisfield, Non-linear Finite Element Analysis of Solids and Structures 1 (1991), section 1.3 (load steps).
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import scipy.sparse as sparse

from femlib.arrays import FloatArray, IntArray
from femlib.assembly.factors import factorise
from femlib.assembly.shells import Shells, assemble
from femlib.assembly.supports import Supports
from femlib.elements import corotational
from femlib.elements.rotations import exp_rotation
from femlib.errors import InputError, SolveError, frozen_floats, is_number
from femlib.mesh import DOFS_PER_NODE, Mesh, dofs_of_nodes

MOST_ITERATIONS = 15
MOST_HALVINGS = 6


@dataclass(frozen=True, slots=True, eq=False)
class Deflection:
    """A structure that has moved far.

    Attributes
    ----------
    fraction : float
        Fraction of the load that it balances.
    displacement : FloatArray
        Of the nodes (n_nodes, 3) [m].
    rotation : FloatArray
        Of the nodes (n_nodes, 3, 3).
    n_iterations : int
        Newton iterations of the last step.
    residual : float
        Norm of the forces out of balance over that of the load.
    """

    fraction: float
    displacement: FloatArray
    rotation: FloatArray
    n_iterations: int = 0
    residual: float = 0.0

    @classmethod
    def none(cls, mesh: Mesh, fraction: float = 0.0) -> "Deflection":
        """Return the structure before it moves."""
        return cls.along(np.zeros(mesh.n_dofs), fraction)

    @classmethod
    def along(cls, moved: FloatArray, fraction: float = 0.0) -> "Deflection":
        """Return the structure displaced by the translations and rotation vectors of `moved` (n_dofs,)."""
        nodal = moved.reshape(-1, DOFS_PER_NODE)
        return cls(fraction, nodal[:, :3].copy(), exp_rotation(nodal[:, 3:]))

    def deformation(self, mesh: Mesh, corners: IntArray) -> FloatArray:
        """Return the displacements (m, 6 n) of the elements with `corners` (m, n) without their rigid motion.

        In global axes before the motion, so that an element's strain rows apply to it.
        """
        moved = corotational.motion(mesh.nodes[corners], self.displacement[corners], self.rotation[corners])
        return moved.deformation.reshape(len(corners), DOFS_PER_NODE * corners.shape[1])


def deflect(
    shells: Shells,
    supports: Supports,
    load: FloatArray,
    fractions: Sequence[float] = (1.0,),
    stiffness_factor: FloatArray | None = None,
    thermal: tuple[FloatArray, FloatArray] | None = None,
    tolerance: float = 1e-8,
) -> list[Deflection]:
    """Return the equilibrium at each fraction of a load, in order.

    Parameters
    ----------
    shells, supports : Shells, Supports
        The structure.
    load : FloatArray
        Nodal forces and moments (n_dofs,) [N, N m] of fixed direction.
    fractions : sequence of float
        Increasing load fractions, at each of which an equilibrium is returned.
    stiffness_factor : FloatArray, optional
        Factor on each element's stiffness and thermal forces (n_elements,), for damage.
    thermal : tuple of FloatArray, optional
        Forces of `thermal_forces`; they grow with the load fraction and turn with their elements.
    tolerance : float
        Newton stops at this norm of the residual over that of the load, or at this last correction of the displacements
        over the largest of them.

    Raises
    ------
    InputError
        If an argument has the wrong shape, is not finite, or the fractions do not increase from above 0.
    SolveError
        If Newton does not converge even in small steps, as beyond a limit load.
    """
    if not is_number(tolerance) or not 0.0 < tolerance < 1.0:
        raise InputError(f"tolerance is {tolerance!r}; expected a share of the load between 0 and 1; 1e-8 is usual")
    steps = frozen_floats(fractions, "load fractions", (-1,))
    if steps.ndim != 1 or not steps.size or not (np.diff(np.concatenate([[0.0], steps])) > 0.0).all():
        raise InputError(f"load fractions are {list(fractions)}; expected increasing numbers above 0; sort them")
    newton = _Newton.of(CorotatedShells.of(shells, stiffness_factor, thermal), supports, load, tolerance)
    found, state = [], Deflection.none(shells.mesh)
    for target in steps.tolist():
        state = newton.follow(state, target)
        found.append(state)
    return found


@dataclass(frozen=True, slots=True, eq=False)
class _Parts:
    """Elements of one kind."""

    corners: IntArray
    points: FloatArray
    stiffness: FloatArray
    thermal: FloatArray

    def motion(self, state: Deflection) -> corotational.Motion:
        return corotational.motion(self.points, state.displacement[self.corners], state.rotation[self.corners])


@dataclass(frozen=True, slots=True, eq=False)
class CorotatedShells:
    """Shells whose elements turn with the structure.

    Attributes
    ----------
    mesh : Mesh
        Nodes and elements.
    """

    mesh: Mesh
    _parts: tuple[_Parts, ...]

    @classmethod
    def of(
        cls,
        shells: Shells,
        stiffness_factor: FloatArray | None = None,
        thermal: tuple[FloatArray, FloatArray] | None = None,
    ) -> "CorotatedShells":
        """Return the shells, arguments as `deflect`."""
        mesh = shells.mesh
        scale = np.ones(mesh.n_elements) if stiffness_factor is None else stiffness_factor
        scale = frozen_floats(scale, "stiffness factor", (mesh.n_elements,))
        if (scale <= 0.0).any():
            bad = int(np.flatnonzero(scale <= 0.0)[0])
            raise InputError(f"stiffness factor of element {bad} is {scale[bad]}; expected more than 0; correct it")
        parts, first = [], 0
        for k, corners in enumerate((mesh.quads, mesh.trias)):
            part = scale[first : first + len(corners), None]
            shape = (len(corners), DOFS_PER_NODE * corners.shape[1])
            warm = np.zeros(shape) if thermal is None else frozen_floats(thermal[k], "thermal forces", shape) * part
            parts.append(_Parts(corners, mesh.nodes[corners], shells.element_stiffness[k] * part[:, :, None], warm))
            first += len(corners)
        return cls(mesh, tuple(parts))

    def forces(self, state: Deflection) -> FloatArray:
        """Return the shells' nodal forces (n_dofs,), thermal ones taken off; in equilibrium they are the loads."""
        total = np.zeros(self.mesh.n_dofs)
        for part in self._parts:
            inner = corotational.forces(part.motion(state), part.stiffness, state.fraction * part.thermal)
            np.add.at(total, dofs_of_nodes(part.corners), inner)
        return total

    def tangent(self, state: Deflection) -> sparse.csc_array:
        """Return the derivative (n_dofs, n_dofs) of the forces by displacements and spins, symmetrised."""
        quads, trias = (
            corotational.tangent(part.motion(state), part.stiffness, state.fraction * part.thermal)
            for part in self._parts
        )
        return assemble(self.mesh, quads, trias)


@dataclass(frozen=True, slots=True, eq=False)
class _Newton:
    shells: CorotatedShells
    supports: Supports
    load: FloatArray
    size: float
    tolerance: float

    @classmethod
    def of(cls, shells: CorotatedShells, supports: Supports, load: FloatArray, tolerance: float) -> "_Newton":
        force = frozen_floats(load, "load", (shells.mesh.n_dofs,))
        rest = Deflection.none(shells.mesh, fraction=1.0)
        size = float(np.linalg.norm((force - shells.forces(rest))[supports.free]))
        return cls(shells, supports, force, size, tolerance)

    def follow(self, start: Deflection, target: float) -> Deflection:
        """Return the equilibrium at `target`, the step halved where Newton fails."""
        state, step, halvings = start, target - start.fraction, 0
        while state.fraction < target:
            goal = target if state.fraction + 1.001 * step >= target else state.fraction + step
            try:
                state = self.balanced(state, goal)
            except (SolveError, np.linalg.LinAlgError) as error:  # an element may have collapsed on the way
                halvings += 1
                if halvings > MOST_HALVINGS:
                    raise SolveError(
                        f"large deflection did not converge from load fraction {state.fraction:.4g} to {goal:.4g} "
                        f"({error}); expected a stable equilibrium; lower the load or give smaller fractions"
                    ) from error
                step *= 0.5
        return state

    def balanced(self, start: Deflection, fraction: float) -> Deflection:
        """Return the equilibrium at `fraction` by Newton's method from `start`."""
        state = Deflection(fraction, start.displacement, start.rotation)
        limit = 1e6 * max(self.size, 1e-300)
        for iteration in range(1, MOST_ITERATIONS + 1):
            matrix = self.supports.reduce(self.shells.tangent(state))
            move = factorise(matrix, self.supports.groups, definite=False).solve(self.residual(state))
            if not np.isfinite(move).all():
                raise SolveError(f"the tangent is singular in iteration {iteration}")
            moved = self.supports.expand(move).reshape(-1, DOFS_PER_NODE)
            rotation = exp_rotation(moved[:, 3:]) @ state.rotation
            state = Deflection(fraction, state.displacement + moved[:, :3], rotation, iteration)
            norm = float(np.linalg.norm(self.residual(state)))
            # the residual of a stiff membrane cannot fall below its rounding; the last correction shows as much
            still = np.abs(moved[:, :3]).max() <= self.tolerance * np.abs(state.displacement).max()
            if still or norm <= self.tolerance * self.size:
                share = norm / self.size if self.size else 0.0
                return Deflection(fraction, state.displacement, state.rotation, iteration, share)
            if not norm < limit:
                break
        raise SolveError(f"residual {norm:.3g} of a load of {self.size:.3g} after {iteration} iterations")

    def residual(self, state: Deflection) -> FloatArray:
        """Return load minus inner forces at the free degrees of freedom (n_free,)."""
        return (state.fraction * self.load - self.shells.forces(state))[self.supports.free]
