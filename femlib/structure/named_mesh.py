"""A mesh as it comes from a file: shells, lines, and sets of elements and nodes by name."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from femlib.arrays import BoolArray, FloatArray, IntArray
from femlib.errors import InputError, MeshError, frozen_floats, frozen_ints
from femlib.kept import ReadOnly

FARTHEST = 1e9
"""Coordinate of a node [m], at most: farther out is no structure but a wrong number."""
MOST_NAMES = 20
"""Names that a message lists."""


@dataclass(frozen=True, slots=True, eq=False)
class NamedMesh:
    """Nodes, shells and lines with named sets; elements are numbered quadrilaterals, triangles, lines.

    Attributes
    ----------
    nodes : FloatArray
        Positions (n_nodes, 3) [m].
    quads, trias, lines : IntArray
        Corners (n_quads, 4), (n_trias, 3) and ends (n_lines, 2).
    element_sets : mapping
        Which elements belong to a set, as truth values (n_elements,), by name.
    node_sets : mapping
        Nodes of a set (n,), by name.
    left_out : mapping
        What else the file has, by its name: how many, or why an array of it names no set.

    Raises
    ------
    MeshError
        If a coordinate is not finite or an element names a missing node.

    Examples
    --------
    >>> import meshio
    >>> points, line = [[0, 0, 0], [0.5, 0, 0], [1, 0, 0]], ("line", [[0, 1], [1, 2]])
    >>> sets = {"cell_sets": {"arm": [[0, 1]]}, "point_sets": {"foot": [0], "tip": [2]}}
    >>> from femlib import read
    >>> mesh = read(meshio.Mesh(points, [line], **sets))
    >>> mesh.lines.tolist(), sorted(mesh.node_sets), dict(mesh.left_out)
    ([[0, 1], [1, 2]], ['foot', 'tip'], {})
    """

    nodes: FloatArray
    quads: IntArray
    trias: IntArray
    lines: IntArray
    element_sets: Mapping[str, BoolArray]
    node_sets: Mapping[str, IntArray]
    left_out: Mapping[str, str] = field(default_factory=lambda: ReadOnly({}))

    def __post_init__(self) -> None:
        points = np.array(self.nodes, dtype=np.float64)
        bad = np.flatnonzero(~(np.abs(points) <= FARTHEST).all(axis=1)) if points.ndim == 2 else points[:0]
        if bad.size:
            raise MeshError(
                f"node {bad[0]} lies at {points[bad[0]].tolist()} m; expected three coordinates up to {FARTHEST:g} m; "
                "repair the mesh"
            )
        object.__setattr__(self, "nodes", frozen_floats(points, "mesh nodes", (-1, 3)))
        for name, width in (("quads", 4), ("trias", 3), ("lines", 2)):
            corners = frozen_ints(getattr(self, name), f"mesh {name}", (-1, width))
            object.__setattr__(self, name, corners)
            if corners.size and not 0 <= corners.min() <= corners.max() < len(points):
                raise MeshError(f"mesh {name} name nodes that do not exist; expected 0 to {len(points) - 1}; repair it")
        object.__setattr__(self, "element_sets", ReadOnly({k: np.array(v) for k, v in self.element_sets.items()}))
        object.__setattr__(self, "node_sets", ReadOnly({k: np.unique(v) for k, v in self.node_sets.items()}))

    @property
    def n_shells(self) -> int:
        """Number of quadrilaterals and triangles."""
        return len(self.quads) + len(self.trias)

    @property
    def n_elements(self) -> int:
        """Number of shells and lines."""
        return self.n_shells + len(self.lines)

    def elements_of(self, name: str) -> BoolArray:
        """Return which elements belong to a set (n_elements,).

        Raises
        ------
        InputError
            If there is no such set, or it is empty.
        """
        if name not in self.element_sets:
            raise InputError(
                f"element set {name!r} is not in the mesh; expected one of {listed(self.element_sets)}"
                f"{self._without_set(name)}; correct it"
            )
        found = self.element_sets[name]
        if not found.any():
            raise InputError(
                f"element set {name!r} is empty; expected shells or lines in it; assign some in the mesh program"
            )
        return found

    def _without_set(self, name: str) -> str:
        """Return why the array that a set is named after has none."""
        reason = self.left_out.get(name.partition(":")[0])
        return f", as the array {name.partition(':')[0]!r} has {reason}" if reason else ""

    def nodes_of(self, name: str) -> IntArray:
        """Return the nodes of a node set, or of the elements of an element set, in increasing order.

        Raises
        ------
        InputError
            If there is no such set, or it is empty.
        """
        if name in self.node_sets:
            found = self.node_sets[name]
        elif name in self.element_sets:
            found = self.nodes_at(self.elements_of(name))
        else:
            names = [*self.node_sets, *self.element_sets]
            raise InputError(f"node set {name!r} is not in the mesh; expected one of {listed(names)}; correct the name")
        if not found.size:
            raise InputError(f"node set {name!r} is empty; expected a node; assign nodes to it in the mesh program")
        return found

    def nodes_at(self, elements: BoolArray) -> IntArray:
        """Return the nodes of the elements where `elements` (n_elements,) is true, in increasing order."""
        parts = np.split(elements, np.cumsum([len(self.quads), len(self.trias)]))
        corners = (self.quads, self.trias, self.lines)
        return np.unique(np.concatenate([own[part].ravel() for own, part in zip(corners, parts, strict=True)]))

    def facing_away(self, name: str, point: Sequence[float] | FloatArray) -> "NamedMesh":
        """Return the mesh with the shells of a set turned so that their top sides face away from a point (3,) [m].

        A mesh program may leave a surface's sides as they came; the top side is where a positive pressure points to,
        and where a gauge of side 1 sits.

        Raises
        ------
        InputError
            If there is no such set, or a shell's plane goes through the point.
        """
        wanted, origin = self.elements_of(name), frozen_floats(point, "point", (3,))
        turned = []
        parts = np.split(wanted, [len(self.quads), self.n_shells])[:2]
        for corners, mask in zip((self.quads, self.trias), parts, strict=True):
            places = self.nodes[corners]
            normal = np.cross(places[:, 2] - places[:, 0], places[:, -1] - places[:, 1])
            outward = np.einsum("ei,ei->e", places.mean(axis=1) - origin, normal)
            flat = np.flatnonzero(
                mask & (np.abs(outward) <= 1e-9 * np.linalg.norm(normal, axis=1) * np.ptp(self.nodes))
            )
            if flat.size:
                raise InputError(
                    f"the plane of shell {corners[flat[0]].tolist()} in {name!r} goes through the point "
                    f"{origin.tolist()}; expected a point on one side of every shell; choose another"
                )
            turned.append(np.where((mask & (outward < 0.0))[:, None], corners[:, ::-1], corners))
        return replace(self, quads=turned[0], trias=turned[1])


def listed(names: Mapping[str, object] | list[str]) -> str:
    """Return the names as a message can list them."""
    every = sorted(names)
    more = f" and {len(every) - MOST_NAMES} more" if len(every) > MOST_NAMES else ""
    return f"{every[:MOST_NAMES]}{more}"
