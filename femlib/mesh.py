"""A shell mesh of quadrilaterals and triangles, with the checks that the elements need.

Elements are numbered quadrilaterals first, then triangles. Each belongs to a named patch ("top", "web", ...), across
whose border strains may jump.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from numbers import Real

import numpy as np

from femlib.arrays import FloatArray, IntArray
from femlib.errors import MeshError, frozen_floats, frozen_ints

DOFS_PER_NODE = 6
"""Translations along x, y, z [m], then rotations about x, y, z [rad]."""


@dataclass(frozen=True, slots=True)
class QualityLimits:
    """Limits of the shape of shell elements.

    Attributes
    ----------
    warp : float
        Distance of a corner from the mean plane over the longest edge. Warped elements carry any load; beyond this
        the surface through four corners is no longer what was meant.
    aspect : float
        Longest over shortest edge.
    distortion : float
        Least over largest corner area of a quadrilateral must exceed this (0 = a corner of 180 degrees).
    """

    warp: float = 0.1
    aspect: float = 40.0
    distortion: float = 0.02

    def __post_init__(self) -> None:
        for name in ("warp", "aspect", "distortion"):
            value: object = getattr(self, name)
            if not isinstance(value, Real) or isinstance(value, bool) or not float(value) >= 0.0:
                raise MeshError(f"quality limit {name} is {value!r}; expected a number of 0 or more; correct it")


@dataclass(frozen=True, slots=True, eq=False)
class Mesh:
    """Nodes and shell elements.

    Attributes
    ----------
    nodes : FloatArray
        Positions (n_nodes, 3) [m].
    quads : IntArray
        Corners (n_quads, 4), counter-clockwise seen from the top side.
    trias : IntArray
        Corners (n_trias, 3), likewise.
    patches : tuple of str
        Names of the patches.
    patch_of_element : IntArray
        Index into `patches` (n_elements,), quadrilaterals first.

    Raises
    ------
    MeshError
        If an element names a missing node, has no area, exceeds `limits`, or has its top side where its neighbour has
        its bottom side (with the element's number).
    """

    nodes: FloatArray
    quads: IntArray
    trias: IntArray
    patches: tuple[str, ...]
    patch_of_element: IntArray
    limits: QualityLimits = QualityLimits()

    def __post_init__(self) -> None:
        if not isinstance(self.limits, QualityLimits):
            raise MeshError(
                f"mesh limits are {self.limits!r}; expected QualityLimits; leave them out for the usual ones"
            )
        object.__setattr__(self, "nodes", frozen_floats(self.nodes, "mesh nodes", (-1, 3)))
        object.__setattr__(self, "quads", frozen_ints(self.quads, "mesh quads", (-1, 4)))
        object.__setattr__(self, "trias", frozen_ints(self.trias, "mesh trias", (-1, 3)))
        counts = (self.n_elements,)
        object.__setattr__(
            self, "patch_of_element", frozen_ints(self.patch_of_element, "mesh patch_of_element", counts)
        )
        if isinstance(self.patches, str) or not all(isinstance(name, str) for name in self.patches):
            raise MeshError(f"mesh patches are {self.patches!r}; expected a tuple of names; put them in a tuple")
        if len(set(self.patches)) != len(self.patches):
            raise MeshError(f"mesh patches are {list(self.patches)}; expected each name once; rename one")
        if not self.n_elements:
            raise MeshError("mesh has no element; expected at least one; give quads or trias their corners")
        _check_patches(self.patch_of_element, len(self.patches))
        for corners, first in ((self.quads, 0), (self.trias, len(self.quads))):
            _check_corners(corners, first, len(self.nodes))
            if len(corners):
                _check_quality(self.nodes[corners], first, self.limits)
        _check_repeats(self.quads, self.trias)
        _check_orientation(self.quads, self.trias, self.patch_of_element)

    @property
    def n_elements(self) -> int:
        """Number of quadrilaterals and triangles."""
        return len(self.quads) + len(self.trias)

    @property
    def n_dofs(self) -> int:
        """Number of degrees of freedom, supports included."""
        return DOFS_PER_NODE * len(self.nodes)

    @property
    def size(self) -> float:
        """Diagonal of the box about the nodes [m]."""
        return float(np.linalg.norm(np.ptp(self.nodes, axis=0)))

    def corners_of(self, element: int) -> IntArray:
        """Return the nodes (4,) or (3,) of an element."""
        n_quads = len(self.quads)
        return np.asarray(self.quads[element] if element < n_quads else self.trias[element - n_quads])

    def elements_in(self, patch: str) -> IntArray:
        """Return the element numbers of a patch."""
        if patch not in self.patches:
            raise MeshError(
                f"patch {patch!r} is not in the mesh; expected one of {list(self.patches)}; correct the name"
            )
        return np.flatnonzero(self.patch_of_element == self.patches.index(patch))

    def centroids(self) -> FloatArray:
        """Return the mean of the corners (n_elements, 3) [m]."""
        return np.concatenate([self.nodes[self.quads].mean(axis=1), self.nodes[self.trias].mean(axis=1)])

    def area_vectors(self) -> FloatArray:
        """Return the normals (n_elements, 3) toward the top side, as long as the area [m^2]."""
        q, t = self.nodes[self.quads], self.nodes[self.trias]
        quads = 0.5 * np.cross(q[:, 2] - q[:, 0], q[:, 3] - q[:, 1])
        return np.concatenate([quads, 0.5 * np.cross(t[:, 1] - t[:, 0], t[:, 2] - t[:, 0])])


def dofs_of_nodes(nodes: IntArray | Sequence[int]) -> IntArray:
    """Return the degrees of freedom (n_nodes, 6) of nodes."""
    return DOFS_PER_NODE * np.asarray(nodes, dtype=np.int64)[..., None] + np.arange(DOFS_PER_NODE)


def shell_sides(quads: IntArray, trias: IntArray) -> tuple[IntArray, IntArray]:
    """Return the sides (n, 2) of shells from each corner to the next, and the shell of each side or corner (n,)."""
    ends = [np.stack([corners, np.roll(corners, -1, axis=1)], axis=2).reshape(-1, 2) for corners in (quads, trias)]
    shell = np.repeat(np.arange(len(quads) + len(trias)), np.repeat([4, 3], [len(quads), len(trias)]))
    return np.concatenate(ends), shell


def warp_heights(points: FloatArray) -> FloatArray:
    """Return the distance (n,) [m] of the farthest corner from the mean plane of elements (n, 3 or 4, 3)."""
    forward = np.roll(points, -1, axis=1) - points
    mean = np.cross(np.roll(forward, 1, axis=1), forward).mean(axis=1)
    normal = mean / np.linalg.norm(mean, axis=1, keepdims=True)
    return np.asarray(np.abs(np.einsum("eki,ei->ek", points - points.mean(axis=1, keepdims=True), normal)).max(axis=1))


def _check_patches(patch_of_element: IntArray, n_patches: int) -> None:
    bad = np.flatnonzero((patch_of_element < 0) | (patch_of_element >= n_patches))
    if bad.size:
        raise MeshError(
            f"element {bad[0]} is of patch number {patch_of_element[bad[0]]}; expected 0 to {n_patches - 1}; "
            "number the patches from zero, in the order of their names"
        )


def _check_corners(corners: IntArray, first: int, n_nodes: int) -> None:
    bad = (corners < 0) | (corners >= n_nodes)
    if bad.any():
        row, column = (int(k) for k in np.argwhere(bad)[0])
        raise MeshError(
            f"element {first + row} names node {corners[row, column]}; expected 0 to {n_nodes - 1}; "
            "number the nodes from zero"
        )


def _check_repeats(quads: IntArray, trias: IntArray) -> None:
    """Refuse the first element that has the same corners as one before it: it would count twice."""
    for corners, first in ((quads, 0), (trias, len(quads))):
        _, kept, count = np.unique(np.sort(corners, axis=1), axis=0, return_index=True, return_counts=True)
        if (count > 1).any():
            named = np.sort(corners[int(kept[np.flatnonzero(count > 1)[0]])])
            same = first + np.flatnonzero((np.sort(corners, axis=1) == named).all(axis=1))
            raise MeshError(
                f"element {same[1]} has the same corners as element {same[0]}, nodes {named.tolist()}; expected each "
                "element once; leave one out"
            )


def _check_quality(points: FloatArray, first: int, limits: QualityLimits) -> None:
    """Refuse the first element of `points` (m, 3 or 4, 3) beyond the limits."""
    edges = np.linalg.norm(np.roll(points, -1, axis=1) - points, axis=2)
    longest, shortest = edges.max(axis=1), edges.min(axis=1)
    _refuse(shortest <= 1e-12 * longest, first, shortest, "a shortest edge of", "m", "more than 0")
    _refuse(
        longest > limits.aspect * shortest, first, longest / shortest, "an aspect ratio of", "", f"<= {limits.aspect:g}"
    )
    forward = np.roll(points, -1, axis=1) - points
    turns = np.cross(np.roll(forward, 1, axis=1), forward)
    mean = turns.mean(axis=1)
    size = np.linalg.norm(mean, axis=1)
    _refuse(size <= 1e-12 * longest**2, first, size, "a mean corner area of", "m^2", "more than 0")
    normal = mean / size[:, None]
    signed = np.einsum("eki,ei->ek", turns, normal)
    worst = signed.min(axis=1) / signed.max(axis=1)
    _refuse(worst < limits.distortion, first, worst, "a corner ratio of", "", f">= {limits.distortion:g}")
    height = warp_heights(points)
    _refuse(height > limits.warp * longest, first, height / longest, "a warp of", "", f"<= {limits.warp:g}")


def _check_orientation(quads: IntArray, trias: IntArray, patch: IntArray) -> None:
    """Refuse the first element that runs along an edge in the same direction as its one neighbour of the same patch."""
    sides, element = shell_sides(quads, trias)
    edges = np.column_stack([np.sort(sides, axis=1), patch[element]])
    _, edge, count = np.unique(edges, axis=0, return_inverse=True, return_counts=True)
    forward = np.bincount(edge.ravel(), weights=sides[:, 0] < sides[:, 1], minlength=len(count))
    wrong = (count == 2) & (forward != 1.0)  # three at one edge are a junction, which has no common side
    if wrong.any():
        order, start = np.argsort(edge.ravel(), kind="stable"), (np.cumsum(count) - count)[wrong]
        first, second = min(zip(element[order[start]].tolist(), element[order[start + 1]].tolist(), strict=True))
        raise MeshError(
            f"element {second} has its top side where its neighbour {first} has its bottom side; expected one side for "
            "a patch; reverse its corners"
        )


def _refuse(bad: np.ndarray, first: int, values: FloatArray, what: str, unit: str, expected: str) -> None:
    if bad.any():
        row = int(np.flatnonzero(bad)[0])
        raise MeshError(
            f"element {first + row} has {what} {values[row]:.3g}{' ' if unit else ''}{unit}; expected {expected}; "
            "refine or straighten the mesh there"
        )
