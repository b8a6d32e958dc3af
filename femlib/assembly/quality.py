"""The share of a solution that is the elements' own stiffness: an estimate after the solution, and a refusal.

Three shares of the strain energy u' K u, whose sum estimates the relative error of the displacements under the load
(in a Galerkin solution the error's energy over the whole is the error of load' u):

warp        A quadrilateral stands on its mean plane, its corners do not: turning it rigidly strains it. With d the
            displacements less the element's rigid motion and r = u - d, the larger of |1 - d' K d / u' K u| and
            r' K r / u' K u.
in-plane    Bending of single elements in their plane, which they know only through their drilling rotations. What four
bending     incompatible membrane modes (1 - xi^2, 1 - eta^2 in each direction) would release: f' M^-1 f with f the
            membrane forces' work on the modes and M the modes' stiffness. By Rayleigh's principle a lower bound of what
            an element with these modes would move more.
mesh        Energy of the distance from the strains to smoother ones: at each node a linear fit to the strains of the
            adjoining elements of the same patch, between the nodes the elements' own shape functions.

Sources: R. H. MacNeal, Finite Elements: Their Design and Performance (1994), section 8.4 (warp); R. L. Taylor, P. J.
Beresford, E. L. Wilson, Int. J. Numer. Meth. Engng 10 (1976) 1211-1219 (modes); O. C. Zienkiewicz, J. Z. Zhu, ibid. 33
(1992) 1331-1364 (fit). Price: what the estimate is worth is a table in docs/wing.md; one element across a strip hides
its twist.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from femlib.arrays import FloatArray, IntArray
from femlib.assembly.factors import factorise
from femlib.assembly.shells import Shells
from femlib.assembly.supports import Supports
from femlib.elements import quad4, tria3
from femlib.elements.frame import resultant_turn
from femlib.elements.rotations import skew
from femlib.errors import InputError, SolveError, frozen_floats, is_number
from femlib.mesh import DOFS_PER_NODE

MOST_ERROR = 0.03
"""Estimated error of the displacements beyond which a solution is refused."""
CORNERS = np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])
GAUSS = CORNERS / np.sqrt(3.0)
MIDDLES = np.array([[0.5, 0.5, 0.0], [0.0, 0.5, 0.5], [0.5, 0.0, 0.5]])
"""Area coordinates of the middles of a triangle's sides."""


@dataclass(frozen=True, slots=True, eq=False)
class Quality:
    """Shares of a solution's strain energy that are the elements' and not the structure's, by element.

    Attributes
    ----------
    warp, in_plane_bending, mesh : FloatArray
        Shares of the whole strain energy (n_elements,), each summed over the elements the share of its kind; those of
        `warp` may cancel.
    rigid : FloatArray
        Share of the rigid parts alone (n_elements,), which cannot cancel.
    """

    warp: FloatArray
    rigid: FloatArray
    in_plane_bending: FloatArray
    mesh: FloatArray

    @property
    def warp_error(self) -> float:
        """Estimated share of the displacements lost to warp."""
        return float(max(abs(self.warp.sum()), self.rigid.sum()))

    @property
    def displacement_error(self) -> float:
        """Estimated relative error of the displacements under the load."""
        return self.warp_error + float(self.in_plane_bending.sum() + self.mesh.sum())

    def refuse(self, limit: float = MOST_ERROR) -> None:
        """Raise SolveError if the estimated error exceeds `limit`."""
        if not is_number(limit) or limit <= 0.0:
            raise InputError(f"limit is {limit!r}; expected a share of the displacements above 0; 0.03 is usual")
        if self.displacement_error <= limit:
            return
        shares = {
            "warp of the elements": (self.warp_error, self.rigid, "refine, or take triangles there"),
            "bending of single elements in their plane": (
                float(self.in_plane_bending.sum()),
                self.in_plane_bending,
                "take more elements over the width that bends",
            ),
            "a coarse mesh": (float(self.mesh.sum()), self.mesh, "refine where the strains change"),
        }
        cause, (share, of_elements, cure) = max(shares.items(), key=lambda item: item[1][0])
        raise SolveError(
            f"displacements are estimated to be {100.0 * self.displacement_error:.3g} % off, {100.0 * share:.3g} % by "
            f"{cause} (most in element {int(of_elements.argmax())}); expected at most {100.0 * limit:.3g} %; {cure}"
        )


def solution_quality(shells: Shells, displacements: FloatArray, factor: FloatArray | None = None) -> Quality:
    """Return the shares of a solution's strain energy that are the elements' own.

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
    own = [kind.energy(kind.deformation) for kind in kinds]
    recovered = _recovered(shells, kinds)
    return Quality(
        warp=np.concatenate([kind.energy(kind.whole) - e for kind, e in zip(kinds, own, strict=True)]) / energy,
        rigid=np.concatenate([kind.energy(kind.whole - kind.deformation) for kind in kinds]) / energy,
        in_plane_bending=np.concatenate([kind.released() for kind in kinds]) / energy,
        mesh=np.concatenate([k.distance(r) for k, r in zip(kinds, recovered, strict=True)]) / energy,
    )


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
    whole, deformation : FloatArray
        Displacements (e, 6 n), and those less the rigid motion.
    axes : FloatArray
        Columns are the elements' axes (e, 3, 3).
    strains : FloatArray
        Membrane strains and curvatures at the points (e, m, 2, 3) in the elements' axes.
    area : FloatArray
        Area of each point (e, m) [m^2].
    shapes : FloatArray
        Shape functions at the points (m, n).
    moduli : FloatArray
        A and D in the elements' axes (e, 2, 3, 3).
    """

    corners: IntArray
    group: IntArray
    points: FloatArray
    matrices: FloatArray
    whole: FloatArray
    deformation: FloatArray
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
        flat = self.axes[:, None, None, :, :2]
        return np.asarray(flat @ plane @ flat.swapaxes(-1, -2)).reshape(*self.strains.shape[:2], 18)

    def distance(self, nodal: FloatArray) -> FloatArray:
        """Return the energy (e,) of the strains' distance from those between nodal tensors (e, n, 18)."""
        between = np.einsum("mn,enk->emk", self.shapes, nodal).reshape(*self.area.shape, 2, 3, 3)
        flat = self.axes[:, None, None, :, :2]
        plane = flat.swapaxes(-1, -2) @ between @ flat
        smooth = np.stack([plane[..., 0, 0], plane[..., 1, 1], 2.0 * plane[..., 0, 1]], axis=-1)
        off = self.strains - smooth
        return np.asarray(np.einsum("em,emkc,ekcd,emkd->e", self.area, off, self.moduli, off, optimize=True))

    def released(self) -> FloatArray:
        """Return the membrane energy (e,) that incompatible modes would release; none in a triangle."""
        if self.corners.shape[1] == tria3.N_NODES:
            return np.zeros(len(self.corners))
        local = ((self.points - self.points.mean(axis=1, keepdims=True)) @ self.axes)[:, :, :2]
        middle = _jacobian(local, 0.0, 0.0)
        moduli, forces, stiffness = self.moduli[:, 0], 0.0, 0.0
        for k, (r, s) in enumerate(GAUSS.tolist()):
            slopes = np.linalg.solve(middle, np.broadcast_to(np.diag([-2.0 * r, -2.0 * s]), middle.shape))
            rows = _mode_rows(slopes)
            # the middle's area instead of the point's own: constant strain then does no work on the modes
            pull = np.einsum("eck,ecd,ed->ek", rows, moduli, self.strains[:, k, 0])
            share = np.linalg.det(middle)
            forces = forces + share[:, None] * pull
            stiffness = stiffness + (share**2 / self.area[:, k])[:, None, None] * (rows.swapaxes(1, 2) @ moduli @ rows)
        amplitudes = np.linalg.solve(stiffness, np.asarray(forces)[:, :, None])[:, :, 0]
        return np.asarray(np.einsum("ek,ek->e", forces, amplitudes))


def _jacobian(local: FloatArray, r: float, s: float) -> FloatArray:
    """Return d(x, y) / d(r, s), row r then row s (e, 2, 2) of corners (e, 4, 2)."""
    along = 0.25 * np.array([[s - 1, 1 - s, 1 + s, -1 - s], [r - 1, -1 - r, 1 + r, 1 - r]])
    return np.asarray(along @ local)


def _mode_rows(slopes: FloatArray) -> FloatArray:
    """Return membrane strains (e, 3, 4) of two modes in x and y, from their slopes (e, xy, mode)."""
    rows = np.zeros((len(slopes), 3, 4))
    rows[:, 0, 0::2], rows[:, 2, 0::2] = slopes[:, 0], slopes[:, 1]
    rows[:, 1, 1::2], rows[:, 2, 1::2] = slopes[:, 1], slopes[:, 0]
    return rows


def _kinds(shells: Shells, moved: FloatArray, factor: FloatArray) -> Iterator[_Kind]:
    """Yield the quadrilaterals, then the triangles."""
    mesh, n_quads = shells.mesh, len(shells.mesh.quads)
    triangle = np.repeat(np.linalg.norm(mesh.area_vectors()[n_quads:], axis=1)[:, None] / 3.0, 3, axis=1)
    for corners, part, matrices in zip(
        (mesh.quads, mesh.trias), (slice(n_quads), slice(n_quads, None)), shells.element_stiffness, strict=True
    ):
        points = mesh.nodes[corners]
        whole = moved[corners]
        deformation = _deformation(points, whole).reshape(len(corners), DOFS_PER_NODE * corners.shape[1])
        if corners.shape[1] == quad4.N_NODES:
            operator = quad4.strain_operators(points, [(r, s) for r, s in GAUSS.tolist()])
            rows, axes = np.stack([operator.membrane, operator.curvature], axis=2), operator.axes
            local = ((points - points.mean(axis=1, keepdims=True)) @ axes)[:, :, :2]
            area = np.stack([np.linalg.det(_jacobian(local, r, s)) for r, s in GAUSS.tolist()], axis=1)
            shapes = np.array([quad4.shape(r, s) for r, s in GAUSS.tolist()])
        else:
            operators = [tria3.strain_operator(own) for own in points]
            constant = np.array([[o.membrane, o.curvature] for o in operators]).reshape(-1, 1, 2, 3, tria3.N_DOFS)
            rows, axes = np.repeat(constant, 3, axis=1), np.array([o.axes for o in operators]).reshape(-1, 3, 3)
            area, shapes = triangle, MIDDLES
        turn = resultant_turn(axes, shells.axis)
        held = np.array([[own.membrane, own.bending] for own in shells.laminates])[shells.section[part]]
        yield _Kind(
            corners=corners,
            group=corners * len(mesh.patches) + mesh.patch_of_element[part, None],
            points=points,
            matrices=matrices * factor[part, None, None],
            whole=whole.reshape(deformation.shape),
            deformation=deformation,
            axes=axes,
            strains=np.einsum("emkci,ei->emkc", rows, deformation, optimize=True),
            area=area,
            shapes=shapes,
            moduli=turn[:, None]
            @ held
            @ turn[:, None].swapaxes(-1, -2)
            * (shells.scale[part] * factor[part])[:, None, None, None],
        )


def _deformation(points: FloatArray, whole: FloatArray) -> FloatArray:
    """Return displacements (e, n, 6) of corners (e, n, 3) less the rigid motion that fits them best."""
    arm = points - points.mean(axis=1, keepdims=True)
    gone = whole[:, :, :3] - whole[:, :, :3].mean(axis=1, keepdims=True)
    inertia = -(skew(arm) @ skew(arm)).sum(axis=1)
    spin = np.linalg.solve(inertia, np.cross(arm, gone).sum(axis=1)[:, :, None])[:, None, :, 0]
    return np.concatenate([gone - np.cross(spin, arm), whole[:, :, 3:] - spin], axis=2)


def _recovered(shells: Shells, kinds: list[_Kind]) -> list[FloatArray]:
    """Return the tensors (e, n, 18) at the corners, each a linear fit to the points of its node's elements."""
    mesh = shells.mesh
    names, group = np.unique(np.concatenate([kind.group.ravel() for kind in kinds]), return_inverse=True)
    node = mesh.nodes[names // len(mesh.patches)]
    first = np.cumsum([0, *(kind.group.size for kind in kinds)])
    groups = [group.ravel()[a : a + k.group.size].reshape(k.group.shape) for a, k in zip(first, kinds, strict=False)]
    normal = np.zeros((len(names), 3))
    for kind, own in zip(kinds, groups, strict=True):
        np.add.at(normal, own, (kind.axes[:, :, 2] * kind.area.sum(axis=1)[:, None])[:, None])
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
