"""Strains of a solution at the integration points of all elements of one kind at once."""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import partial

import numpy as np

from femlib.arrays import FloatArray, IntArray
from femlib.assembly.shells import Shells
from femlib.elements import quad4, tria3
from femlib.elements.surface import GAUSS, frame, shape
from femlib.mesh import DOFS_PER_NODE


@dataclass(frozen=True, slots=True, eq=False)
class PointStrains:
    """Elements of one kind with m points of integration and n corners.

    Attributes
    ----------
    corners : IntArray
        Nodes (e, n).
    group : IntArray
        Number of each corner's node and part (`Shells.smooth`) (e, n).
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
        ((A, B), (B, D)) in those axes (e, 2, 2, 3, 3).
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
        return np.asarray(np.einsum("em,emkc,eklcd,emld->e", self.area, off, self.moduli, off, optimize=True))

    def membrane_forces(self) -> FloatArray:
        """Return the forces per length (xx, yy, xy) at the points (e, m, 3) [N/m], tension positive."""
        return np.asarray(np.einsum("elcd,emld->emc", self.moduli[:, 0], self.strains, optimize=True))

    def point_forces(self, hindered: FloatArray | float = 0.0) -> FloatArray:
        """Return the membrane forces times the points' areas as tensors (e, m, 2, 2) [N m].

        `hindered` (e, 1, 3) [N/m]: what would hold all thermal strains back, which push by it.
        """
        xx, yy, xy = np.moveaxis((self.membrane_forces() - hindered) * self.area[:, :, None], 2, 0)
        return np.moveaxis(np.array([[xx, xy], [xy, yy]]), (0, 1), (2, 3))


def point_strains(shells: Shells, moved: FloatArray, factor: FloatArray) -> Iterator[PointStrains]:
    """Yield the quadrilaterals, then the triangles, of shells that moved by (n_nodes, 6).

    `factor` (n_elements,) scales each element's stiffness, for damage. Quadrilaterals have Gauss's four points,
    triangles the middles of their sides.
    """
    mesh, n_quads = shells.mesh, len(shells.mesh.quads)
    blocks = [[[own.membrane, own.coupling], [own.coupling, own.bending]] for own in shells.laminates]
    for corners, part, matrices, kind in zip(
        (mesh.quads, mesh.trias),
        (slice(n_quads), slice(n_quads, None)),
        shells.element_stiffness,
        (_quad_rows, _tria_rows),
        strict=True,
    ):
        points = mesh.nodes[corners]
        whole = moved[corners].reshape(len(corners), DOFS_PER_NODE * corners.shape[1])
        rows, axes, area, shapes = shells.point_rows.get(kind.__name__, partial(kind, shells, points, part))
        yield PointStrains(
            corners=corners,
            group=corners * shells.n_smooth + shells.smooth[part, None],
            points=points,
            matrices=matrices * factor[part, None, None],
            whole=whole,
            axes=axes,
            strains=np.einsum("emkci,ei->emkc", rows, whole, optimize=True),
            area=area,
            shapes=shapes,
            moduli=np.array(blocks)[shells.section[part]]
            * (shells.scale[part] * factor[part])[:, None, None, None, None],
        )


def _quad_rows(shells: Shells, points: FloatArray, part: slice) -> tuple[FloatArray, ...]:
    """Return rows (e, m, 2, 3, 24), axes and areas of Gauss's points and the shape functions there."""
    places = [(r, s) for r, s in GAUSS.tolist()]
    operator = quad4.strain_operators(points, places, shells.axis, (shells.laminates, shells.section[part]))
    area = np.stack([frame(points, r, s, shells.axis).area for r, s in places], axis=1)
    rows = np.stack([operator.membrane, operator.curvature], axis=2)
    return rows, operator.axes, area, np.array([shape(r, s) for r, s in places])


def _tria_rows(shells: Shells, points: FloatArray, part: slice) -> tuple[FloatArray, ...]:
    """Return the same (e, m, 2, 3, 18) of the middles of the triangles' sides."""
    operator = tria3.strain_operators(points, tria3.MIDDLES, shells.axis, (shells.laminates, shells.section[part]))
    whole = np.linalg.norm(shells.mesh.area_vectors()[len(shells.mesh.quads) :], axis=1)
    rows = np.stack([operator.membrane, operator.curvature], axis=2)
    return rows, operator.axes, np.repeat(whole[:, None] / 3.0, 3, axis=1), tria3.MIDDLES
