"""Supports: degrees of freedom held at zero."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import scipy.sparse as sparse
from scipy.sparse.csgraph import connected_components

from femlib.arrays import FloatArray, IntArray
from femlib.errors import InputError, frozen_ints, is_whole
from femlib.mesh import DOFS_PER_NODE, Mesh, dofs_of_nodes

NO_LINKS = np.zeros((0, 2), dtype=np.int64)
RIGID = 1e-12
"""A motion whose square at the held degrees of freedom is below this share of the largest is not held."""


@dataclass(frozen=True, slots=True, eq=False)
class Supports:
    """Degrees of freedom that are held at zero.

    Attributes
    ----------
    n_dofs : int
        All degrees of freedom.
    free : IntArray
        Those that move.
    """

    n_dofs: int
    free: IntArray

    def __post_init__(self) -> None:
        free = frozen_ints(self.free, "free degrees of freedom", (-1,))
        object.__setattr__(self, "free", free)
        if not is_whole(self.n_dofs) or (free.size and not 0 <= free.min() <= free.max() < self.n_dofs):
            raise InputError(
                f"free degrees of freedom are not all in 0 to {self.n_dofs} - 1; expected increasing numbers of the "
                "mesh's; make them with Supports.holding"
            )
        if (np.diff(free) <= 0).any():
            raise InputError("free degrees of freedom do not increase; expected each once, in order; sort them")

    @classmethod
    def holding(
        cls,
        mesh: Mesh,
        held: Sequence[int] | IntArray,
        links: IntArray = NO_LINKS,
        grounded: IntArray = NO_LINKS[:, 0],
    ) -> "Supports":
        """Hold the degrees of freedom `held`.

        Parameters
        ----------
        mesh : Mesh
            The shells.
        held : sequence of int
            Degrees of freedom at zero.
        links : IntArray
            Pairs of nodes (n, 2) that beams or springs join.
        grounded : IntArray
            Degrees of freedom that a spring to the ground resists: they stay free, but stop a rigid motion.

        Raises
        ------
        InputError
            If a number is outside the mesh, nothing is held, or a part of the mesh can still move as a rigid body.
        """
        numbers = np.unique(frozen_ints(held, "held degrees of freedom", (-1,)))
        is_held = numbers.size or len(grounded)
        if not is_held or (numbers.size and (numbers[0] < 0 or numbers[-1] >= mesh.n_dofs)):
            raise InputError(
                f"supports name {numbers.size} degrees of freedom, not all in 0 to {mesh.n_dofs - 1}; "
                "expected at least six in the mesh; correct the numbers"
            )
        _check_held(mesh, np.union1d(numbers, grounded), links)
        return cls(mesh.n_dofs, np.setdiff1d(np.arange(mesh.n_dofs), numbers))

    @classmethod
    def clamping(cls, mesh: Mesh, nodes: IntArray) -> "Supports":
        """Hold all six degrees of freedom of `nodes`."""
        return cls.holding(mesh, dofs_of_nodes(frozen_ints(nodes, "clamped nodes", (-1,))).ravel())

    @property
    def groups(self) -> IntArray:
        """Node of each free degree of freedom (n_free,)."""
        return self.free // DOFS_PER_NODE

    def reduce(self, matrix: sparse.csc_array) -> sparse.csc_array:
        """Return the rows and columns that move."""
        return sparse.csc_array(matrix[self.free][:, self.free])

    def expand(self, values: FloatArray) -> FloatArray:
        """Return (n_dofs, ...) with zeros at the supports from (n_free, ...)."""
        full = np.zeros((self.n_dofs, *values.shape[1:]))
        full[self.free] = values
        return full


def _check_held(mesh: Mesh, held: IntArray, links: IntArray) -> None:
    """Refuse supports under which a part of the mesh, elements joined by nodes, can move without straining."""
    n = len(mesh.nodes)
    pairs = [(corners[:, :1], corners[:, 1:]) for corners in (mesh.quads, mesh.trias, links)]
    first, other = (np.concatenate([np.broadcast_to(p[k], p[1].shape).ravel() for p in pairs]) for k in (0, 1))
    graph = sparse.coo_array((np.ones(len(first)), (first, other)), shape=(n, n))
    n_parts, part = connected_components(graph, directed=False)
    lone = np.setdiff1d(np.arange(n), np.concatenate([first, other]))
    free = lone[np.isin(dofs_of_nodes(lone), held).sum(axis=1) < DOFS_PER_NODE]
    if free.size:
        raise InputError(f"node {free[0]} belongs to no element; expected nodes of elements; leave it out or hold it")
    for number in np.setdiff1d(np.arange(n_parts), part[lone]):
        nodes = np.flatnonzero(part == number)
        motion = _free_motion(mesh.nodes[nodes], held[part[held // DOFS_PER_NODE] == number], nodes)
        if motion is not None:
            raise InputError(
                f"the part of the mesh with node {nodes[0]} ({len(nodes)} of {n} nodes, {n_parts} parts) can still "
                f"move as a rigid body, {motion}; expected six motions held; hold it, or join it to the others by nodes"
            )


def _free_motion(points: FloatArray, held: IntArray, nodes: IntArray) -> str | None:
    """Return in words the rigid motion of points (m, 3) that held degrees of freedom of `nodes` leave, if one."""
    middle = points.mean(axis=0)
    arms = (points - middle) / max(float(np.ptp(points, axis=0).max()), 1e-300)
    motions = np.zeros((len(points), DOFS_PER_NODE, DOFS_PER_NODE))
    motions[:, :3, :3] = np.eye(3)
    for axis in range(3):
        motions[:, :3, 3 + axis] = np.cross(np.eye(3)[axis], arms)
        motions[:, 3 + axis, 3 + axis] = 1.0
    rows = motions[np.searchsorted(nodes, held // DOFS_PER_NODE), held % DOFS_PER_NODE]
    values, vectors = np.linalg.eigh(rows.T @ rows)
    if values[0] > RIGID * max(values[-1], 1.0):
        return None
    names = ("along x", "along y", "along z", "about x", "about y", "about z")
    return names[int(np.abs(vectors[:, 0]).argmax())]
