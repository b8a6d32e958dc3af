"""The buckling load of any damage state, from modes of sampled states, in milliseconds.

On the span Phi of sampled buckling modes, orthonormal in K_0,

    (1 - sum_i mu_i Phi' K_i Phi) a = -factor * sum_m c_m (Phi' K_sigma,m Phi) a,

where K_sigma,m is that of mode m of the sampled states' membrane forces, and the forces' coefficients c are linear in
the reduced model's parts p: c = W_0 p - sum_i mu_i W_i p. Exact forces would make the factor one from above (Ritz).
"""

from dataclasses import dataclass

import numpy as np
import scipy.linalg as linalg
from numpy.typing import NDArray

from femlib.arrays import FloatArray, IntArray
from femlib.assembly import Shells
from femlib.assembly.buckling import geometric_stiffness, matrix_buckling, slope_rows
from femlib.assembly.integration import point_strains
from femlib.components import DamagedStructure
from femlib.mesh import DOFS_PER_NODE, dofs_of_nodes
from femlib.rom.vibration import orthonormal

MODES_EACH = 2
"""Buckling modes of a sampled state; of the undamaged structure three times as many."""
SAME = 1e-2
"""Share of the largest singular value below which sampled modes say nothing new."""
MOST_FORCES = 24
"""Modes of the membrane forces."""


@dataclass(frozen=True, slots=True, eq=False)
class ReducedBuckling:
    """The equations of the module's docstring.

    Attributes
    ----------
    lost : FloatArray
        Phi' K_i Phi (n_parameters, N, N).
    pressed : NDArray[np.float32]
        Phi' K_sigma,m Phi (M, N, N).
    forces : FloatArray
        W_0, then W_i (n_parameters + 1, M, n_parts).
    """

    lost: FloatArray
    pressed: NDArray[np.float32]
    forces: FloatArray

    def factor(self, damage: FloatArray, parts: FloatArray) -> float:
        """Return the factor on the load of damages (n_parameters,) with the model's parts (n_parts,); inf for none."""
        n = self.pressed.shape[1]
        if n == 0:  # no sampled state buckles
            return float("inf")
        stiffness, compressed = self._matrices(damage, parts)
        most = (n - 1, n - 1)
        top = linalg.eigh(compressed, stiffness, eigvals_only=True, subset_by_index=most, check_finite=False)[0]
        return float(1.0 / top) if top > 0.0 else float("inf")

    def holds(self, damage: FloatArray, parts: FloatArray, factor: float) -> bool:
        """Return whether `factor` on the load is below that of `factor`: one factorisation in place of eigenvalues."""
        stiffness, compressed = self._matrices(damage, parts)
        try:
            linalg.cholesky(stiffness - factor * compressed, lower=True, overwrite_a=True, check_finite=False)
        except linalg.LinAlgError:
            return False
        return True

    def _matrices(self, damage: FloatArray, parts: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the stiffness (N, N) that is left, and what the load takes from it at factor 1."""
        hit = damage.nonzero()[0]
        share = self.forces[0] @ parts - np.tensordot(damage[hit], self.forces[hit + 1] @ parts, 1)
        stiffness = np.eye(self.pressed.shape[1]) - np.tensordot(damage[hit], self.lost[hit], 1)
        return stiffness, -np.tensordot(share.astype(self.pressed.dtype), self.pressed, 1).astype(np.float64)


@dataclass(frozen=True, slots=True, eq=False)
class Sampled:
    """Damage states with what the reduced model makes of them.

    Attributes
    ----------
    states : FloatArray
        Damages (n, n_parameters).
    parts : FloatArray
        The reduced model's parts (n, n_parts).
    """

    states: FloatArray
    parts: FloatArray


def reduce_buckling(
    structure: DamagedStructure, motion: FloatArray, solved: Sampled, forced: Sampled
) -> ReducedBuckling:
    """Return the reduced equations.

    Parameters
    ----------
    structure : DamagedStructure
        The full model, of shells alone.
    motion : FloatArray
        Displacements (n_dofs, n_parts) of the reduced model's parts.
    solved : Sampled
        States whose buckling modes are solved, the undamaged first.
    forced : Sampled
        States whose membrane forces are sampled.
    """
    shells = structure.shells
    basis = _basis(structure, motion, solved)
    lost = np.array([basis.T @ (shells.stiffness(own.elements) @ basis) for own in structure.components])
    slopes, element = _slopes(shells, basis)
    fields = np.array([_forces(shells, column) for column in motion.T.astype(np.float64)])
    owned = np.array([own.elements[element].repeat(4) for own in structure.components], dtype=np.float64)
    samples = (forced.parts @ fields) * (1.0 - forced.states @ owned)
    modes = np.linalg.svd(samples, full_matrices=False)[2][:MOST_FORCES]
    forces = np.array([modes @ fields.T, *((modes * own) @ fields.T for own in owned)])
    pressed = np.array([_pressed(mode.reshape(-1, 2, 2), slopes) for mode in modes], dtype=np.float32)
    return ReducedBuckling(lost, pressed, forces)


def _basis(structure: DamagedStructure, motion: FloatArray, solved: Sampled) -> FloatArray:
    """Return sampled buckling modes (n_dofs, N), orthonormal in the undamaged stiffness."""
    shells, supports = structure.shells, structure.supports
    sound, found = shells.stiffness(), []
    for number, (damage, part) in enumerate(zip(solved.states, solved.parts, strict=True)):
        factor = structure.stiffness_left(damage)
        stiffness = shells.stiffness(factor=factor)
        pressed = geometric_stiffness(shells, motion @ part, factor)
        modes = matrix_buckling(stiffness, pressed, supports, MODES_EACH * (3 if number == 0 else 1))
        found += [mode.shape / np.sqrt(mode.shape @ (sound @ mode.shape)) for mode in modes]
    return orthonormal(np.array(found).T, sound, SAME) if found else np.zeros((supports.n_dofs, 0))


def _slopes(shells: Shells, basis: FloatArray) -> tuple[FloatArray, IntArray]:
    """Return the slopes (n_points, 2, 3, N) of modes at all points, and each point's element (n_points,)."""
    slopes, elements, first = [], [], 0
    for kind in point_strains(shells, np.zeros((len(shells.mesh.nodes), DOFS_PER_NODE)), np.ones(shells.n_elements)):
        if not len(kind.corners):  # quadrilaterals alone, or triangles alone
            continue
        moved = basis[dofs_of_nodes(kind.corners).reshape(len(kind.corners), -1)]
        rows = slope_rows(shells, kind)
        n_points, n = rows.shape[0] * rows.shape[1], basis.shape[1]
        slopes.append(np.einsum("emaik,ekn->emain", rows, moved, optimize=True).reshape(n_points, 2, 3, n))
        elements.append(np.repeat(first + np.arange(len(kind.corners)), rows.shape[1]))
        first += len(kind.corners)
    return np.concatenate(slopes), np.concatenate(elements)


def _forces(shells: Shells, moved: FloatArray) -> FloatArray:
    """Return the membrane forces (4 n_points,) of displacements (n_dofs,), as tensors times area."""
    kinds = point_strains(shells, moved.reshape(-1, DOFS_PER_NODE), np.ones(shells.n_elements))
    return np.concatenate([kind.point_forces().ravel() for kind in kinds])


def _pressed(forces: FloatArray, slopes: FloatArray) -> FloatArray:
    """Return Phi' K_sigma Phi (N, N) of forces (n_points, 2, 2)."""
    n = slopes.shape[-1]
    pulled = np.einsum("pab,pbin->pain", forces, slopes, optimize=True)
    return np.asarray(slopes.reshape(slopes.size // max(n, 1), n).T @ pulled.reshape(pulled.size // max(n, 1), n))
