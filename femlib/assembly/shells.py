"""Shells with their sections, and the global matrices assembled from their elements."""

from dataclasses import dataclass, field

import numpy as np
import scipy.sparse as sparse

from femlib.arrays import BoolArray, FloatArray, IntArray
from femlib.elements import quad4, tria3
from femlib.errors import InputError, frozen_floats, frozen_ints
from femlib.material import Laminate
from femlib.mesh import Mesh, dofs_of_nodes


@dataclass(frozen=True, slots=True, eq=False)
class Shells:
    """A mesh with its sections: everything that the stiffness depends on.

    Attributes
    ----------
    mesh : Mesh
        Nodes and elements.
    laminates : tuple of Laminate
        Sections.
    section : IntArray
        Index into `laminates` (n_elements,).
    scale : FloatArray
        Factor on each element's stiffness (n_elements,), for moduli that vary over the structure.
    axis : FloatArray
        Global direction (3,) whose projection on an element is its laminate's axis.
    unit_thermal : list
        Kept by `femlib.assembly.loads`: the elements' thermal forces per unit, once they were asked for.
    """

    mesh: Mesh
    laminates: tuple[Laminate, ...]
    section: IntArray
    scale: FloatArray
    axis: FloatArray
    unit_thermal: list[FloatArray] = field(init=False, repr=False, default_factory=list)
    _matrices: tuple[FloatArray, FloatArray] = field(init=False, repr=False)

    def __post_init__(self) -> None:
        n = self.mesh.n_elements
        object.__setattr__(self, "section", frozen_ints(self.section, "section", (n,)))
        object.__setattr__(self, "scale", frozen_floats(self.scale, "stiffness scale", (n,)))
        object.__setattr__(self, "axis", frozen_floats(self.axis, "axis", (3,)))
        if (self.scale <= 0.0).any():
            bad = int(np.flatnonzero(self.scale <= 0.0)[0])
            raise InputError(f"stiffness scale of element {bad} is {self.scale[bad]}; expected more than 0; correct it")
        k = len(self.mesh.quads)
        quads = quad4.stiffness(self.mesh.nodes[self.mesh.quads], self.laminates, self.section[:k], self.axis)
        trias = tria3.stiffness(self.mesh.nodes[self.mesh.trias], self.laminates, self.section[k:], self.axis)
        quads *= self.scale[:k, None, None]
        trias *= self.scale[k:, None, None]
        object.__setattr__(self, "_matrices", (quads, trias))

    @property
    def element_stiffness(self) -> tuple[FloatArray, FloatArray]:
        """The elements' matrices (n_quads, 24, 24) and (n_trias, 18, 18) in global axes."""
        return self._matrices

    def stiffness(self, elements: BoolArray | None = None) -> sparse.csc_array:
        """Return the stiffness (n_dofs, n_dofs), of all elements or of those where `elements` (n_elements,) is true."""
        return assemble(self.mesh, *self._matrices, elements)

    def mass(self) -> sparse.csc_array:
        """Return the consistent mass matrix (n_dofs, n_dofs) [kg, kg m, kg m^2]."""
        k = len(self.mesh.quads)
        quads = quad4.mass(self.mesh.nodes[self.mesh.quads], self.laminates, self.section[:k])
        trias = tria3.mass(self.mesh.nodes[self.mesh.trias], self.laminates, self.section[k:])
        return assemble(self.mesh, quads, trias)


def assemble(mesh: Mesh, quads: FloatArray, trias: FloatArray, elements: BoolArray | None = None) -> sparse.csc_array:
    """Add element matrices (n_quads, 24, 24) and (n_trias, 18, 18) into one sparse matrix."""
    keep = np.ones(mesh.n_elements, dtype=bool) if elements is None else elements
    k = len(mesh.quads)
    rows, columns, values = [], [], []
    for corners, matrices, wanted in ((mesh.quads, quads, keep[:k]), (mesh.trias, trias, keep[k:])):
        dofs = dofs_of_nodes(corners[wanted]).reshape(int(wanted.sum()), matrices.shape[1])
        rows.append(np.repeat(dofs, matrices.shape[1], axis=1).ravel())
        columns.append(np.tile(dofs, (1, matrices.shape[1])).ravel())
        values.append(matrices[wanted].ravel())
    triplets = (np.concatenate(values), (np.concatenate(rows), np.concatenate(columns)))
    return sparse.csc_array(sparse.coo_array(triplets, shape=(mesh.n_dofs, mesh.n_dofs)))
