"""What a solution is worth: an estimate of its error after it is solved, and a refusal.

In a Galerkin solution the error's energy over the whole is the error of load' u. It is estimated by the energy of the
distance from the strains to smoother ones: at each node a linear fit to the strains of the adjoining elements of the
same patch, between the nodes the elements' own shape functions.

Source: O. C. Zienkiewicz, J. Z. Zhu, Int. J. Numer. Meth. Engng 33 (1992) 1331-1364. Price: what the estimate is worth
is a table in docs/wing.md; one element across a strip hides its twist.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from femlib.arrays import FloatArray, IntArray
from femlib.assembly.factors import factorise
from femlib.assembly.shells import Shells
from femlib.assembly.supports import Supports
from femlib.elements import quad4, tria3
from femlib.elements.surface import GAUSS, frame, shape
from femlib.errors import InputError, SolveError, frozen_floats, is_number
from femlib.mesh import DOFS_PER_NODE

MOST_ERROR = 0.03
"""Estimated error of the displacements beyond which a solution is refused."""


@dataclass(frozen=True, slots=True, eq=False)
class Quality:
    """Shares of a solution's strain energy that are the mesh's and not the structure's, by element.

    Attributes
    ----------
    mesh : FloatArray
        Shares of the whole strain energy (n_elements,).
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
    kinds = [kind for kind in _kinds(shells, moved, scale) if len(kind.corners)]
    energy = sum(float(kind.energy(kind.whole).sum()) for kind in kinds)
    if not energy > 0.0:
        raise SolveError("displacements have no strain energy; expected those of a loaded structure; load it")
    recovered = _recovered(shells, kinds)
    return Quality(np.concatenate([k.distance(r) for k, r in zip(kinds, recovered, strict=True)]) / energy)


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


@dataclass(frozen=True, slots=True, eq=False)
class _Kind:
    """Elements of one kind with m points of integration and n corners.

    Attributes
    ----------
    corners : IntArray
        Nodes (e, n).
    group : IntArray
        Number of each corner's node and patch (e, n).
    points : FloatArray
        Corners (e, n, 3) [m].
    matrices : FloatArray
        Stiffness (e, 6 n, 6 n).
    whole : FloatArray
        Displacements (e, 6 n).
    axes : FloatArray
        Columns are the axes at the points (e, m, 3, 3).
    strains : FloatArray
        Membrane strains and curvatures at the points (e, m, 2, 3) in those axes.
    area : FloatArray
        Area of each point (e, m) [m^2].
    shapes : FloatArray
        Shape functions at the points (m, n).
    moduli : FloatArray
        A and D in those axes (e, 2, 3, 3).
    """

    corners: IntArray
    group: IntArray
    points: FloatArray
    matrices: FloatArray
    whole: FloatArray
    axes: FloatArray
    strains: FloatArray
    area: FloatArray
    shapes: FloatArray
    moduli: FloatArray

    def energy(self, moved: FloatArray) -> FloatArray:
        """Return u' K u (e,) of displacements (e, 6 n)."""
        return np.asarray(np.einsum("ei,eij,ej->e", moved, self.matrices, moved, optimize=True))

    def tensors(self) -> FloatArray:
        """Return strains and curvatures at the points as tensors in global axes (e, m, 18)."""
        plane = np.empty((*self.strains.shape[:3], 2, 2))
        plane[..., 0, 0], plane[..., 1, 1] = self.strains[..., 0], self.strains[..., 1]
        plane[..., 0, 1] = plane[..., 1, 0] = 0.5 * self.strains[..., 2]
        flat = self.axes[:, :, None, :, :2]
        return np.asarray(flat @ plane @ flat.swapaxes(-1, -2)).reshape(*self.strains.shape[:2], 18)

    def distance(self, nodal: FloatArray) -> FloatArray:
        """Return the energy (e,) of the strains' distance from those between nodal tensors (e, n, 18)."""
        between = np.einsum("mn,enk->emk", self.shapes, nodal).reshape(*self.area.shape, 2, 3, 3)
        flat = self.axes[:, :, None, :, :2]
        plane = flat.swapaxes(-1, -2) @ between @ flat
        smooth = np.stack([plane[..., 0, 0], plane[..., 1, 1], 2.0 * plane[..., 0, 1]], axis=-1)
        off = self.strains - smooth
        return np.asarray(np.einsum("em,emkc,ekcd,emkd->e", self.area, off, self.moduli, off, optimize=True))


def _kinds(shells: Shells, moved: FloatArray, factor: FloatArray) -> Iterator[_Kind]:
    """Yield the quadrilaterals, then the triangles."""
    mesh, n_quads = shells.mesh, len(shells.mesh.quads)
    triangle = np.repeat(np.linalg.norm(mesh.area_vectors()[n_quads:], axis=1)[:, None] / 3.0, 3, axis=1)
    for corners, part, matrices in zip(
        (mesh.quads, mesh.trias), (slice(n_quads), slice(n_quads, None)), shells.element_stiffness, strict=True
    ):
        points = mesh.nodes[corners]
        whole = moved[corners].reshape(len(corners), DOFS_PER_NODE * corners.shape[1])
        held = np.array([[own.membrane, own.bending] for own in shells.laminates])[shells.section[part]]
        if corners.shape[1] == quad4.N_NODES:
            places = [(r, s) for r, s in GAUSS.tolist()]
            operator = quad4.strain_operators(points, places, shells.axis, (shells.laminates, shells.section[part]))
            area = np.stack([frame(points, r, s, shells.axis).area for r, s in places], axis=1)
            shapes = np.array([shape(r, s) for r, s in places])
        else:
            sections = shells.laminates, shells.section[part]
            operator = tria3.strain_operators(points, tria3.MIDDLES, shells.axis, sections)
            area, shapes = triangle, tria3.MIDDLES
        rows, axes = np.stack([operator.membrane, operator.curvature], axis=2), operator.axes
        yield _Kind(
            corners=corners,
            group=corners * len(mesh.patches) + mesh.patch_of_element[part, None],
            points=points,
            matrices=matrices * factor[part, None, None],
            whole=whole,
            axes=axes,
            strains=np.einsum("emkci,ei->emkc", rows, whole, optimize=True),
            area=area,
            shapes=shapes,
            moduli=held * (shells.scale[part] * factor[part])[:, None, None, None],
        )


def _recovered(shells: Shells, kinds: list[_Kind]) -> list[FloatArray]:
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
