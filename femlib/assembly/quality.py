"""What a solution is worth: an estimate of its error after it is solved, and a refusal.

In a Galerkin solution the error's energy over the whole is the error of load' u. It is estimated by the energy of the
distance from the strains to smoother ones: at each node a linear fit to the strains of the adjoining elements of the
same patch, between the nodes the elements' own shape functions.

Source: O. C. Zienkiewicz, J. Z. Zhu, Int. J. Numer. Meth. Engng 33 (1992) 1331-1364. Price: what the estimate is worth
is a table in docs/wing.md; one element across a strip hides its twist.
"""

from dataclasses import dataclass

import numpy as np

from femlib.arrays import FloatArray
from femlib.assembly.factors import factorise
from femlib.assembly.integration import PointStrains, point_strains
from femlib.assembly.shells import Shells
from femlib.assembly.supports import Supports
from femlib.errors import InputError, SolveError, frozen_floats, is_number
from femlib.mesh import DOFS_PER_NODE

MOST_ERROR = 0.03
"""Estimated error of the displacements beyond which a solution is refused."""
TRIANGLE = 2.0
"""Weight of a triangle's share: flat facets of a curved surface hide some of their error from its neighbours. Of random
curved panels of triangles (seed 1) the true error was up to 2.8 times the share without it."""


@dataclass(frozen=True, slots=True, eq=False)
class Quality:
    """Shares of a solution's strain energy that are the mesh's and not the structure's, by element.

    Attributes
    ----------
    mesh : FloatArray
        Shares of the whole strain energy (n_elements,), a triangle's weighted by `TRIANGLE`.
    """

    mesh: FloatArray

    @property
    def displacement_error(self) -> float:
        """Estimated relative error of the displacements under the load."""
        return float(self.mesh.sum())

    def refuse(self, limit: float = MOST_ERROR) -> None:
        """Raise SolveError if the estimated error exceeds `limit`."""
        if not is_number(limit) or limit <= 0.0:
            raise InputError(f"limit is {limit!r}; expected a share of the displacements above 0; 0.03 is usual")
        if self.displacement_error > limit:
            raise SolveError(
                f"displacements are estimated to be {100.0 * self.displacement_error:.3g} % off by a coarse mesh (most "
                f"in element {int(self.mesh.argmax())}); expected at most {100.0 * limit:.3g} %; refine where the "
                "strains change"
            )


def solution_quality(shells: Shells, displacements: FloatArray, factor: FloatArray | None = None) -> Quality:
    """Return the shares of a solution's strain energy that are the mesh's.

    Parameters
    ----------
    shells : Shells
        The structure.
    displacements : FloatArray
        Of all degrees of freedom (n_dofs,) under one load [m, rad].
    factor : FloatArray, optional
        Factor on each element's stiffness (n_elements,), for damage.

    Raises
    ------
    InputError
        If a number of entries is wrong or one is not finite.
    SolveError
        If the displacements have no strain energy.
    """
    mesh = shells.mesh
    moved = frozen_floats(displacements, "displacements", (mesh.n_dofs,)).reshape(-1, DOFS_PER_NODE)
    scale = np.ones(mesh.n_elements) if factor is None else frozen_floats(factor, "factor", (mesh.n_elements,))
    kinds = [kind for kind in point_strains(shells, moved, scale) if len(kind.corners)]
    energy = sum(float(kind.energy(kind.whole).sum()) for kind in kinds)
    if not energy > 0.0:
        raise SolveError("displacements have no strain energy; expected those of a loaded structure; load it")
    recovered = _recovered(shells, kinds)
    shares = np.concatenate([k.distance(r) for k, r in zip(kinds, recovered, strict=True)]) / energy
    shares[len(mesh.quads) :] *= TRIANGLE
    return Quality(shares)


def checked_solution(shells: Shells, supports: Supports, load: FloatArray, limit: float = MOST_ERROR) -> FloatArray:
    """Return the displacements (n_dofs,) under nodal forces (n_dofs,) [N, N m], judged by `solution_quality`.

    Raises
    ------
    InputError
        If the load has another number of entries or one is not finite.
    SolveError
        If the structure is not held, is not loaded, or the displacements are estimated to be farther off than `limit`.
    """
    force = frozen_floats(load, "load", (supports.n_dofs,))[supports.free]
    moved = supports.expand(factorise(supports.reduce(shells.stiffness()), supports.groups).solve(force))
    solution_quality(shells, moved).refuse(limit)
    return moved


def _recovered(shells: Shells, kinds: list[PointStrains]) -> list[FloatArray]:
    """Return the tensors (e, n, 18) at the corners, each a linear fit to the points of its node's elements."""
    mesh = shells.mesh
    names, group = np.unique(np.concatenate([kind.group.ravel() for kind in kinds]), return_inverse=True)
    node = mesh.nodes[names // len(mesh.patches)]
    first = np.cumsum([0, *(kind.group.size for kind in kinds)])
    groups = [group.ravel()[a : a + k.group.size].reshape(k.group.shape) for a, k in zip(first, kinds, strict=False)]
    normal = np.zeros((len(names), 3))
    for kind, own in zip(kinds, groups, strict=True):
        np.add.at(normal, own, np.einsum("emi,em->ei", kind.axes[..., 2], kind.area)[:, None])
    tangents = _tangents(normal)
    matrix, right = np.zeros((len(names), 3, 3)), np.zeros((len(names), 3, 18))
    for kind, own in zip(kinds, groups, strict=True):
        values, places = kind.tensors(), kind.shapes @ kind.points
        size = np.sqrt(kind.area.sum(axis=1))
        for corner in own.T:
            offset = (places - node[corner][:, None]) / size[:, None, None]
            basis = np.concatenate([np.ones((*offset.shape[:2], 1)), offset @ tangents[corner]], axis=2)
            np.add.at(matrix, corner, basis.swapaxes(1, 2) @ basis)
            np.add.at(right, corner, basis.swapaxes(1, 2) @ values)
    fitted = (np.linalg.pinv(matrix, rcond=1e-9, hermitian=True)[:, :1] @ right)[:, 0]
    return [fitted[own] for own in groups]


def _tangents(normals: FloatArray) -> FloatArray:
    """Return two directions across normals (n, 3) as columns (n, 3, 2); of any length but not parallel to it."""
    away = np.eye(3)[np.abs(normals).argmin(axis=1)]
    first = np.cross(normals, away)
    second = np.cross(normals, first)
    both = np.stack([first, second], axis=2)
    return np.asarray(both / np.maximum(np.linalg.norm(both, axis=1, keepdims=True), 1e-300))
