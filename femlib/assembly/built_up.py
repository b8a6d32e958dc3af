"""Shells with beams, springs and point masses: one structure, its parts numbered shells, beams, springs.

A spring between two nodes apart pushes along the line that joins them; one to the ground, or between two nodes at one
place, has a stiffness for each translation and rotation in global axes.
"""

from dataclasses import dataclass, field

import numpy as np
import scipy.sparse as sparse

from femlib.arrays import BoolArray, FloatArray, IntArray
from femlib.assembly.shells import Shells
from femlib.elements import beam2
from femlib.elements.beam2 import BeamSection
from femlib.errors import InputError, frozen_floats, frozen_ints
from femlib.mesh import DOFS_PER_NODE, Mesh, dofs_of_nodes


@dataclass(frozen=True, slots=True, eq=False)
class Beams:
    """Beams between nodes of a shell mesh.

    Attributes
    ----------
    ends : IntArray
        Nodes (n_beams, 2).
    sections : tuple of BeamSection
        Sections.
    section : IntArray
        Index into `sections` (n_beams,).
    """

    ends: IntArray
    sections: tuple[BeamSection, ...]
    section: IntArray

    def __post_init__(self) -> None:
        object.__setattr__(self, "ends", frozen_ints(self.ends, "beam ends", (-1, 2)))
        object.__setattr__(self, "section", frozen_ints(self.section, "beam section", (len(self.ends),)))

    @classmethod
    def none(cls) -> "Beams":
        """Return no beam."""
        return cls(np.zeros((0, 2), dtype=np.int64), (), np.zeros(0, dtype=np.int64))


@dataclass(frozen=True, slots=True, eq=False)
class Springs:
    """Springs to the ground or between two nodes.

    Attributes
    ----------
    ends : IntArray
        Nodes (n_springs, 2); -1 as the second is the ground.
    stiffness : FloatArray
        (n_springs, 6) along and about the global axes [N/m, N m/rad]; between nodes apart the first number alone, along
        the line that joins them.
    """

    ends: IntArray
    stiffness: FloatArray

    def __post_init__(self) -> None:
        object.__setattr__(self, "ends", frozen_ints(self.ends, "spring ends", (-1, 2)))
        object.__setattr__(
            self, "stiffness", frozen_floats(self.stiffness, "spring stiffness", (len(self.ends), DOFS_PER_NODE))
        )
        bad = np.flatnonzero((self.stiffness < 0.0).any(axis=1) | ~self.stiffness.any(axis=1))
        if bad.size:
            raise InputError(
                f"spring {bad[0]} has the stiffness {self.stiffness[bad[0]].tolist()}; expected numbers of 0 or more, "
                "one above 0; correct it"
            )

    @classmethod
    def none(cls) -> "Springs":
        """Return no spring."""
        return cls(np.zeros((0, 2), dtype=np.int64), np.zeros((0, DOFS_PER_NODE)))

    @property
    def grounded(self) -> IntArray:
        """Degrees of freedom that a spring to the ground resists."""
        rows = self.ends[:, 1] < 0
        return dofs_of_nodes(self.ends[rows, 0])[self.stiffness[rows] > 0.0]

    def matrices(self, nodes: FloatArray) -> FloatArray:
        """Return the stiffness matrices (n_springs, 12, 12) between nodes (n_nodes, 3)."""
        along = nodes[self.ends[:, 1]] - nodes[self.ends[:, 0]]
        length = np.linalg.norm(along, axis=1)
        is_line = (self.ends[:, 1] >= 0) & (length > 0.0)
        six = np.zeros((len(self.ends), DOFS_PER_NODE, DOFS_PER_NODE))
        six[:, range(DOFS_PER_NODE), range(DOFS_PER_NODE)] = self.stiffness
        unit = along[is_line] / length[is_line, None]
        six[is_line] = 0.0
        six[is_line, :3, :3] = self.stiffness[is_line, 0, None, None] * unit[:, :, None] * unit[:, None]
        return np.block([[six, -six], [-six, six]])


@dataclass(frozen=True, slots=True, eq=False)
class BuiltUp(Shells):
    """Shells with beams, springs and point masses.

    Attributes
    ----------
    beams : Beams
        Beams between nodes of the mesh.
    springs : Springs
        Springs at nodes of the mesh.
    point_masses : FloatArray
        Masses at all nodes (n_nodes,) [kg].
    """

    beams: Beams = field(default_factory=Beams.none)
    springs: Springs = field(default_factory=Springs.none)
    point_masses: FloatArray = field(default_factory=lambda: np.zeros(0))
    _beam_matrices: FloatArray = field(init=False, repr=False)

    def __post_init__(self) -> None:
        Shells.__post_init__(self)  # a class with slots is made twice, which super() without arguments does not see
        n = len(self.mesh.nodes)
        masses = self.point_masses if len(self.point_masses) else np.zeros(n)
        object.__setattr__(self, "point_masses", frozen_floats(masses, "point masses", (n,)))
        for what, ends, least in (("beam", self.beams.ends, 0), ("spring", self.springs.ends, -1)):
            bad = np.flatnonzero(((ends < [0, least]) | (ends >= n)).any(axis=1))
            if bad.size:
                raise InputError(
                    f"{what} {bad[0]} names the nodes {ends[bad[0]].tolist()}; expected 0 to {n - 1}; correct them"
                )
        beams = beam2.stiffness(self.mesh.nodes[self.beams.ends], self.beams.sections, self.beams.section)
        object.__setattr__(self, "_beam_matrices", beams)

    @property
    def n_elements(self) -> int:
        """Number of shells, beams and springs."""
        return self.mesh.n_elements + len(self.beams.ends) + len(self.springs.ends)

    @property
    def links(self) -> IntArray:
        """Pairs of nodes (n, 2) that beams and springs join."""
        springs = self.springs.ends[self.springs.ends[:, 1] >= 0]
        return np.concatenate([self.beams.ends, springs])

    def stiffness(self, elements: BoolArray | None = None, factor: FloatArray | None = None) -> sparse.csc_array:
        """Return the stiffness (n_dofs, n_dofs), of all parts or of those where `elements` (n_elements,) is true.

        `factor` (n_elements,) scales each part's, for damage.
        """
        n_shells, n_parts = self.mesh.n_elements, self.n_elements
        scale = np.ones(n_parts) if factor is None else frozen_floats(factor, "factor", (n_parts,))
        kept = scale if elements is None else np.where(elements, scale, 0.0)
        total = Shells.stiffness(self, None if elements is None else elements[:n_shells], scale[:n_shells])
        return sparse.csc_array(total + self._others(kept))

    def other_energy(self, moved: FloatArray, factor: FloatArray) -> float:
        """Return u' K u of beams and springs, of displacements (n_dofs,), with a factor on each part (n_parts,)."""
        return float(moved @ (self._others(factor) @ moved))

    def _others(self, factor: FloatArray) -> sparse.csc_array:
        """Return the stiffness (n_dofs, n_dofs) of beams and springs with a factor on each part (n_parts,)."""
        left = factor[self.mesh.n_elements :]
        ends = np.concatenate([self.beams.ends, self.springs.ends])
        matrices = np.concatenate([self._beam_matrices, self.springs.matrices(self.mesh.nodes)])
        own = left != 0.0
        return _joined(self.mesh, ends[own], matrices[own] * left[own, None, None])

    def touched(self, elements: BoolArray) -> BoolArray:
        """Return which degrees of freedom (n_dofs,) the parts have where `elements` (n_elements,) is true."""
        is_touched = Shells.touched(self, elements)
        ends = np.concatenate([self.beams.ends, self.springs.ends])[elements[self.mesh.n_elements :]]
        is_touched[dofs_of_nodes(ends[ends >= 0]).ravel()] = True
        return is_touched

    def mass(self) -> sparse.csc_array:
        """Return the consistent mass matrix (n_dofs, n_dofs) [kg, kg m, kg m^2], point masses included."""
        beams = beam2.mass(self.mesh.nodes[self.beams.ends], self.beams.sections, self.beams.section)
        lumped = np.zeros((len(self.mesh.nodes), DOFS_PER_NODE))
        lumped[:, :3] = self.point_masses[:, None]
        total = Shells.mass(self) + _joined(self.mesh, self.beams.ends, beams)
        return sparse.csc_array(total + sparse.diags_array(lumped.ravel()))


def _joined(mesh: Mesh, ends: IntArray, matrices: FloatArray) -> sparse.csc_array:
    """Add matrices (n, 12, 12) of parts between two nodes (n, 2) into one; what acts on the ground, -1, is left out."""
    dofs = dofs_of_nodes(ends).reshape(len(ends), 2 * DOFS_PER_NODE)
    rows, columns = np.repeat(dofs, 2 * DOFS_PER_NODE, axis=1).ravel(), np.tile(dofs, 2 * DOFS_PER_NODE).ravel()
    kept = (rows >= 0) & (columns >= 0)
    triplets = (matrices.ravel()[kept], (rows[kept], columns[kept]))
    return sparse.csc_array(sparse.coo_array(triplets, shape=(mesh.n_dofs, mesh.n_dofs)))
