"""One problem: shells, supports, a load, what is read and what it should be. Whoever solves it gets the same case."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from femlib.arrays import FloatArray, IntArray
from femlib.assembly import Judge, Quality, Shells, Supports, factorise, solution_quality
from femlib.material import Laminate
from femlib.mesh import DOFS_PER_NODE, Mesh, QualityLimits

Place = Callable[[FloatArray, FloatArray], FloatArray]
"""From (u, v) in the unit square to places (..., 3) [m]."""
SLENDER = QualityLimits(aspect=1e3)
DIAGONALS = ("first diagonal", "second diagonal")


@dataclass(frozen=True, slots=True, eq=False)
class Case:
    """A problem on one mesh.

    Attributes
    ----------
    shells : Shells
        The shells.
    node : IntArray
        Nodes as a grid (n_u + 1, n_v + 1).
    held : IntArray
        Degrees of freedom held at zero.
    load : FloatArray
        Nodal forces (n_dofs,) [N, N m].
    read : FloatArray
        The answer is `read` @ displacements (n_dofs,), of translations alone.
    reference : float
        What it should be.
    source : str
        Who says so.
    """

    shells: Shells
    node: IntArray
    held: IntArray
    load: FloatArray
    read: FloatArray
    reference: float
    source: str

    @property
    def supports(self) -> Supports:
        """What is held."""
        return Supports.holding(self.shells.mesh, self.held)

    def displacements(self) -> FloatArray:
        """Return femlib's displacements (n_dofs,)."""
        supports = self.supports
        factors = factorise(supports.reduce(self.shells.stiffness()), supports.groups)
        return supports.expand(factors.solve(self.load[supports.free]))

    def ratio(self, moved: FloatArray | None = None) -> float:
        """Return the answer of displacements (n_dofs,), femlib's if not given, over the reference."""
        return float(self.read @ (self.displacements() if moved is None else moved)) / self.reference

    def judged(self, is_refined: bool = True) -> tuple[float, Quality]:
        """Return femlib's ratio and the estimate of its error, by a finer mesh too where that is wanted and small."""
        moved = self.displacements()
        if not is_refined:
            return self.ratio(moved), solution_quality(self.shells, moved)
        return self.ratio(moved), Judge(self.shells, self.supports).quality(self.load, moved, moved, None)

    def in_triangles(self, diagonal: str) -> "Case":
        """Return the case with each quadrilateral cut in two along its first or second diagonal; loads stay."""
        return replace(self, shells=cut(self.shells, diagonal))


def cut(shells: Shells, diagonal: str) -> Shells:
    """Return shells with each quadrilateral cut in two triangles along its first or second diagonal."""
    mesh = shells.mesh
    turned = np.roll(mesh.quads, -DIAGONALS.index(diagonal), axis=1)
    trias = np.stack([turned[:, [0, 1, 2]], turned[:, [0, 2, 3]]], axis=1).reshape(-1, 3)
    none = np.zeros((0, 4), dtype=np.int64)
    halves = Mesh(mesh.nodes, none, trias, mesh.patches, np.repeat(mesh.patch_of_element, 2), mesh.limits)
    return Shells(halves, shells.laminates, np.repeat(shells.section, 2), np.repeat(shells.scale, 2), shells.axis)


def mapped(
    place: Place,
    n_u: int,
    n_v: int,
    laminate: Laminate,
    axis: tuple[float, float, float] = (0.0, 0.0, 0.0),
) -> tuple[Shells, IntArray]:
    """Return shells on the image of the unit square under `place`, and the nodes (n_u + 1, n_v + 1)."""
    u, v = np.meshgrid(np.linspace(0, 1, n_u + 1), np.linspace(0, 1, n_v + 1), indexing="ij")
    number = np.arange(u.size).reshape(u.shape)
    quads = np.stack([number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:]], axis=-1).reshape(-1, 4)
    nodes = place(u, v).reshape(-1, 3)
    zeros = np.zeros(len(quads), dtype=np.int64)
    mesh = Mesh(nodes, quads, np.zeros((0, 3), dtype=np.int64), ("shell",), zeros, SLENDER)
    return Shells(mesh, (laminate,), zeros, np.ones(len(quads)), np.array(axis)), number


def hold(nodes: IntArray, directions: str) -> IntArray:
    """Return degrees of freedom of nodes: u, v, w translations, x, y, z rotations, in the order of "uvwxyz"."""
    numbers = np.array(["uvwxyz".index(d) for d in directions], dtype=np.int64)
    return np.asarray(DOFS_PER_NODE * nodes.ravel()[:, None] + numbers).ravel()


def at(shells: Shells, node: int, direction: str, size: float = 1.0) -> FloatArray:
    """Return the row (n_dofs,) of one nodal force or displacement."""
    row = np.zeros(shells.mesh.n_dofs)
    row[hold(np.array([node]), direction)] = size
    return row


def along_end(shells: Shells, nodes: IntArray, direction: str) -> FloatArray:
    """Return the row (n_dofs,) of a unit force spread over a row of nodes, which is also their mean displacement."""
    shares = np.ones(len(nodes))
    shares[[0, -1]] = 0.5
    return np.asarray(sum(at(shells, int(k), direction, f) for k, f in zip(nodes, shares / shares.sum(), strict=True)))
