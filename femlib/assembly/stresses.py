"""Strains and stresses of plies at the corners of shells, and the factors on the load at which the plies fail.

At each node the strains are a linear fit to those of the elements of the same part (`recovery`, `Shells.smooth`), so
that a corner of two patches, or where a layup ends, has the strains of both. Damage and a stiffness scale take a share
of a ply's stress; the ply fails at the strain of its card: what is left of it carries the stress of the whole.

Source of the last: J. Lemaitre, J. Eng. Mater. Technol. 107 (1985) 83-89 (equivalence of strain).
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from femlib.arrays import FloatArray, IntArray
from femlib.assembly.integration import point_strains
from femlib.assembly.recovery import nodal_tensors
from femlib.assembly.shells import Shells
from femlib.elements.surface import CORNERS, frame
from femlib.errors import InputError, frozen_floats
from femlib.material import Laminate, Ply
from femlib.mesh import DOFS_PER_NODE
from femlib.strength import checked_criterion, strain_factors, tsai_wu_factors, von_mises

Faces = Sequence[tuple[int, float]]
"""Numbers of plies of a laminate and heights [m] at which they are looked at."""


@dataclass(frozen=True, slots=True, eq=False)
class Block:
    """The corners of one laminate's elements at one height of one ply.

    Attributes
    ----------
    ply : Ply
        The ply.
    number : int
        Its number in the laminate, from the bottom.
    height : float
        Height over the reference surface [m].
    corners : IntArray
        Corners among those of all elements (m,).
    """

    ply: Ply
    number: int
    height: float
    corners: IntArray

    def strain(self, corner_strains: FloatArray) -> FloatArray:
        """Return the strains (m, 3) in fibre axes of strains and curvatures (n_corners, 6, ...) in the shell's."""
        own = corner_strains[self.corners]
        return np.asarray(np.tensordot(own[:, :3] + self.height * own[:, 3:], self.ply.strain_turn(), (1, 1)))

    def free_strain(self, warmth: FloatArray) -> FloatArray:
        """Return the thermal strains (m, 3) in fibre axes of temperatures and gradients (m, 2) of the corners."""
        rise = warmth[:, 0] + self.height * warmth[:, 1]
        return np.outer(rise, [self.ply.expansion_1, self.ply.expansion_2, 0.0])

    def factors(self, strain: FloatArray, criterion: str) -> FloatArray:
        """Return the factors (m,) on a load at which the ply fails, of its strains (m, 3) in fibre axes."""
        ply, strength = self.ply, self.ply.strength
        if strength is None:
            raise InputError(
                f"ply {self.number} (young_1 {ply.young_1:g} Pa) has no strength; expected that of every ply; give it "
                "one: Ply(..., strength=Strength(...)), isotropic_plate(..., strength=yielding_at(...))"
            )
        if criterion == "max strain":
            return strain_factors(strength, (ply.young_1, ply.young_2, ply.shear_12), strain)
        stress = strain @ fibre_stiffness(ply)
        if criterion == "tsai-wu":
            return tsai_wu_factors(strength, stress)
        return np.asarray(strength.tension_1 / np.maximum(von_mises(stress), 1e-300))


@dataclass(frozen=True, slots=True, eq=False)
class Stresses:
    """Plies of a solution at the corners of all elements.

    Attributes
    ----------
    element, node, ply : IntArray
        Element, node and number of the ply (n,).
    height : FloatArray
        Height over the reference surface (n,) [m].
    strain, stress : FloatArray
        In fibre axes (n, 3), order (1, 2, 12), tension positive [-] and [Pa].
    error : float
        Estimated error of the strains by the mesh: the largest of a corner over the largest strain (`checked_peak`).
    blocks : tuple of Block
        What stands together, in the order of the rows.
    """

    element: IntArray
    node: IntArray
    ply: IntArray
    height: FloatArray
    strain: FloatArray
    stress: FloatArray
    error: float
    blocks: tuple[Block, ...]

    @property
    def von_mises(self) -> FloatArray:
        """Von Mises' stress (n,) [Pa]."""
        return von_mises(self.stress)

    def failure_factors(self, criterion: str = "tsai-wu") -> FloatArray:
        """Return the factors (n,) on the load at which each ply fails there.

        Raises
        ------
        InputError
            If there is no such criterion, or a ply has no strength.
        """
        return block_factors(self.blocks, self.strain, criterion)


def block_factors(blocks: Sequence[Block], strain: FloatArray, criterion: str) -> FloatArray:
    """Return the factors (n,) of strains (n, 3), row by row of the blocks."""
    named, first = checked_criterion(criterion), np.cumsum([0, *(len(block.corners) for block in blocks)])
    parts = [b.factors(strain[start : start + len(b.corners)], named) for b, start in zip(blocks, first, strict=False)]
    return np.concatenate(parts)


def fibre_stiffness(ply: Ply) -> FloatArray:
    """Return the stiffness (3, 3) [Pa] in fibre axes."""
    back = np.linalg.inv(ply.strain_turn())
    return np.asarray(back.T @ ply.plane_stress() @ back)


def ply_faces(laminate: Laminate) -> Faces:
    """Return the bottom and top of each ply.

    Raises
    ------
    InputError
        If the laminate was not made of plies.
    """
    if not laminate.plies:
        raise InputError("a laminate has no plies; expected those that it was stacked from; make it with laminate")
    edges = np.concatenate([[0.0], np.cumsum([ply.thickness for ply in laminate.plies])]) - 0.5 * laminate.thickness
    return [(k, float(z)) for k in range(len(laminate.plies)) for z in edges[k : k + 2]]


def blocks_of(shells: Shells, faces: Sequence[Faces] | None = None) -> tuple[Block, ...]:
    """Return the blocks of shells; `faces` has those of each laminate, bottoms and tops of plies if not given."""
    wanted = [ply_faces(own) for own in shells.laminates] if faces is None else faces
    section = shells.section[corner_elements(shells)]
    return tuple(
        Block(own.plies[k], k, z, np.flatnonzero(section == number))
        for number, own in enumerate(shells.laminates)
        for k, z in wanted[number]
    )


def ply_stresses(
    shells: Shells,
    moved: FloatArray,
    factor: FloatArray | None = None,
    error: float = float("nan"),
    faces: Sequence[Faces] | None = None,
    warmth: FloatArray | None = None,
    length: float = 0.0,
) -> Stresses:
    """Return strains and stresses of plies of shells that moved by (n_dofs,) [m, rad].

    Parameters
    ----------
    shells, moved
        The structure and its displacements.
    factor : FloatArray, optional
        Factor on each part's stiffness (n_parts,), for damage.
    error : float
        Estimated error to carry.
    faces : sequence, optional
        As for `blocks_of`.
    warmth : FloatArray, optional
        Temperature of each shell's middle and its rise toward the top (n_shells, 2) [K, K/m]; the free strains that
        they cause are taken off.
    length : float
        Length that strains are means over [m], as for `corner_strains`.

    Raises
    ------
    InputError
        If the displacements are not those of the mesh, or a laminate has no plies.
    """
    blocks, strains = blocks_of(shells, faces), corner_strains(shells, moved, length)
    element, node = corner_elements(shells), np.concatenate([shells.mesh.quads.ravel(), shells.mesh.trias.ravel()])
    left = shells.scale if factor is None else shells.scale * factor[: shells.mesh.n_elements]
    strain = [block.strain(strains) for block in blocks]
    if warmth is not None:
        strain = [own - b.free_strain(warmth[element[b.corners]]) for b, own in zip(blocks, strain, strict=True)]
    stress = [
        left[element[b.corners], None] * (own @ fibre_stiffness(b.ply)) for b, own in zip(blocks, strain, strict=True)
    ]
    corners = np.concatenate([block.corners for block in blocks])
    numbers, heights = ([getattr(b, name) for b in blocks] for name in ("number", "height"))
    sizes = [len(block.corners) for block in blocks]
    return Stresses(
        element=element[corners],
        node=node[corners],
        ply=np.repeat(np.array(numbers, dtype=np.int64), sizes),
        height=np.repeat(np.array(heights), sizes),
        strain=np.concatenate(strain),
        stress=np.concatenate(stress),
        error=error,
        blocks=blocks,
    )


def corner_elements(shells: Shells) -> IntArray:
    """Return the element of each corner (n_corners,): the quadrilaterals' four, then the triangles' three."""
    sizes = np.repeat([4, 3], [len(shells.mesh.quads), len(shells.mesh.trias)])
    return np.repeat(np.arange(shells.mesh.n_elements), sizes)


def corner_strains(shells: Shells, moved: FloatArray, length: float = 0.0) -> FloatArray:
    """Return strains and curvatures (n_corners, 6) at the corners in the laminates' axes of displacements (n_dofs,).

    They are means over a length [m], as `nodal_tensors`.
    """
    return _in_laminates(shells, *_tensors(shells, moved, length))


def _tensors(shells: Shells, moved: FloatArray, length: float = 0.0) -> tuple[IntArray, FloatArray]:
    whole = frozen_floats(moved, "displacements", (shells.mesh.n_dofs,)).reshape(-1, DOFS_PER_NODE)
    kinds = point_strains(shells, whole, np.ones(shells.mesh.n_elements))
    return nodal_tensors(shells, [kind for kind in kinds if len(kind.corners)], length)


def _in_laminates(shells: Shells, names: IntArray, tensors: FloatArray) -> FloatArray:
    """Return (n_corners, 6) from tensors (g, 18) at nodes and parts of the names (g,)."""
    mesh, found = shells.mesh, []
    for corners, first in ((mesh.quads, 0), (mesh.trias, len(mesh.quads))):
        group = corners * shells.n_smooth + shells.smooth[first : first + len(corners), None]
        held = tensors[np.searchsorted(names, group)].reshape(*corners.shape, 2, 3, 3)
        flat = _corner_axes(mesh.nodes[corners], shells.axis)[:, :, None, :, :2]
        plane = flat.swapaxes(-1, -2) @ held @ flat
        strains = np.stack([plane[..., 0, 0], plane[..., 1, 1], 2.0 * plane[..., 0, 1]], axis=-1)
        found.append(strains.reshape(-1, 6))
    return np.concatenate(found)


def _corner_axes(points: FloatArray, axis: FloatArray) -> FloatArray:
    """Return the laminate's axes as columns (e, n, 3, 3) at the corners (e, n, 3)."""
    if points.shape[1] == len(CORNERS):
        return np.stack([frame(points, r, s, axis).axes for r, s in CORNERS.tolist()], axis=1)
    # a triangle is half of a parallelogram
    whole = np.concatenate([points, points[:, :1] + points[:, 2:] - points[:, 1:2]], axis=1)
    return np.repeat(frame(whole, 0.0, 0.0, axis).axes[:, None], 3, axis=1)
