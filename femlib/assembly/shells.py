"""Shells with their sections, and the global matrices assembled from their elements."""

from dataclasses import dataclass, field

import numpy as np
import scipy.sparse as sparse

from femlib.arrays import BoolArray, FloatArray, IntArray
from femlib.elements import quad4, tria3
from femlib.errors import InputError, frozen_floats, frozen_ints
from femlib.kept import Kept
from femlib.material import Laminate
from femlib.mesh import DOFS_PER_NODE, Mesh, dofs_of_nodes

THICKEST, THINNEST = 0.5, 1e-8
"""Thickness over the mesh's size, beyond which lengths are in two units."""
LEAST_IN_PLANE = 1e-6
"""Share of an axis that must lie in an element whose stiffness depends on direction."""


STEP = 1.25
"""Ratio of moduli from which on neighbours have strains of their own: in one layup a taper changes them less."""


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
    smooth : IntArray
        Number of the part of each element (n_elements,) within which strains are smooth: one patch and section, and
        moduli within a factor of `STEP` or so. They jump where a layup ends.
    unit_thermal : Kept
        Of `femlib.assembly.loads`: the elements' thermal forces per unit by the elements' name, once asked for.
    point_rows : Kept
        Of `femlib.assembly.integration`: the elements' rows of strain, likewise; as large as their matrices.
    nodal_rows : Kept
        Of `femlib.assembly.recovery`: nodes and the weights of points there by length.
    """

    mesh: Mesh
    laminates: tuple[Laminate, ...]
    section: IntArray
    scale: FloatArray
    axis: FloatArray
    smooth: IntArray = field(init=False, repr=False)
    unit_thermal: Kept[str, FloatArray] = field(init=False, repr=False, default_factory=Kept)
    point_rows: Kept[str, tuple[FloatArray, ...]] = field(init=False, repr=False, default_factory=Kept)
    nodal_rows: Kept[float, tuple[IntArray, sparse.csr_array]] = field(init=False, repr=False, default_factory=Kept)
    _matrices: tuple[FloatArray, FloatArray] = field(init=False, repr=False)

    def __post_init__(self) -> None:
        n = self.mesh.n_elements
        object.__setattr__(self, "section", frozen_ints(self.section, "section", (n,)))
        object.__setattr__(self, "scale", frozen_floats(self.scale, "stiffness scale", (n,)))
        object.__setattr__(self, "axis", frozen_floats(self.axis, "axis", (3,)))
        if (self.scale <= 0.0).any():
            bad = int(np.flatnonzero(self.scale <= 0.0)[0])
            raise InputError(f"stiffness scale of element {bad} is {self.scale[bad]}; expected more than 0; correct it")
        _check_sections(self.laminates, self.section)
        _check_thickness(self.mesh, self.laminates)
        _check_axis(self.mesh, self.laminates, self.section, self.axis)
        layup = (self.mesh.patch_of_element, self.section, np.rint(np.log(self.scale) / np.log(STEP)))
        object.__setattr__(self, "smooth", np.unique(np.stack(layup), axis=1, return_inverse=True)[1].ravel())
        k = len(self.mesh.quads)
        quads = quad4.stiffness(self.mesh.nodes[self.mesh.quads], self.laminates, self.section[:k], self.axis)
        trias = tria3.stiffness(self.mesh.nodes[self.mesh.trias], self.laminates, self.section[k:], self.axis)
        quads *= self.scale[:k, None, None]
        trias *= self.scale[k:, None, None]
        object.__setattr__(self, "_matrices", (quads, trias))

    @property
    def n_elements(self) -> int:
        """Number of parts whose stiffness `stiffness` can tell apart."""
        return self.mesh.n_elements

    @property
    def n_smooth(self) -> int:
        """Number of the parts of `smooth`."""
        return int(self.smooth.max()) + 1

    @property
    def element_stiffness(self) -> tuple[FloatArray, FloatArray]:
        """The elements' matrices (n_quads, 24, 24) and (n_trias, 18, 18) in global axes."""
        return self._matrices

    def stiffness(self, elements: BoolArray | None = None, factor: FloatArray | None = None) -> sparse.csc_array:
        """Return the stiffness (n_dofs, n_dofs), of all elements or of those where `elements` (n_elements,) is true.

        `factor` (n_elements,) scales each element's, for damage.
        """
        if factor is None:
            return assemble(self.mesh, *self._matrices, elements)
        scale, k = frozen_floats(factor, "factor", (self.mesh.n_elements,))[:, None, None], len(self.mesh.quads)
        return assemble(self.mesh, self._matrices[0] * scale[:k], self._matrices[1] * scale[k:], elements)

    def other_energy(self, moved: FloatArray, factor: FloatArray) -> float:
        """Return u' K u of what is no shell, of displacements (n_dofs,), with a factor on each part (n_parts,)."""
        return 0.0

    def touched(self, elements: BoolArray) -> BoolArray:
        """Return which degrees of freedom (n_dofs,) the elements have where `elements` (n_elements,) is true."""
        is_touched, k = np.zeros((len(self.mesh.nodes), DOFS_PER_NODE), dtype=bool), len(self.mesh.quads)
        is_touched[self.mesh.quads[elements[:k]]] = True
        is_touched[self.mesh.trias[elements[k : self.mesh.n_elements]]] = True
        return is_touched.ravel()

    def mass(self) -> sparse.csc_array:
        """Return the consistent mass matrix (n_dofs, n_dofs) [kg, kg m, kg m^2]."""
        k = len(self.mesh.quads)
        quads = quad4.mass(self.mesh.nodes[self.mesh.quads], self.laminates, self.section[:k])
        trias = tria3.mass(self.mesh.nodes[self.mesh.trias], self.laminates, self.section[k:])
        return assemble(self.mesh, quads, trias)


def _check_sections(laminates: tuple[Laminate, ...], section: IntArray) -> None:
    if not isinstance(laminates, tuple) or not all(isinstance(laminate, Laminate) for laminate in laminates):
        raise InputError(f"laminates are a {type(laminates).__name__}; expected a tuple of Laminate; put them in one")
    bad = np.flatnonzero((section < 0) | (section >= len(laminates)))
    if bad.size:
        raise InputError(
            f"element {bad[0]} has section {section[bad[0]]}; expected 0 to {len(laminates) - 1}, the laminates' "
            "numbers; number the sections from zero"
        )


def _check_thickness(mesh: Mesh, laminates: tuple[Laminate, ...]) -> None:
    size = mesh.size
    for number, laminate in enumerate(laminates):
        if not THINNEST * size <= laminate.thickness <= THICKEST * size:
            raise InputError(
                f"laminate {number} is {laminate.thickness:.3g} m thick on a mesh {size:.3g} m across; expected "
                f"{THINNEST:g} to {THICKEST:g} of that; give all lengths in metres"
            )


def _check_axis(mesh: Mesh, laminates: tuple[Laminate, ...], section: IntArray, axis: FloatArray) -> None:
    directed = ~np.array([laminate.is_isotropic for laminate in laminates])[section]
    normal = mesh.area_vectors()
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    seen = np.linalg.norm(np.cross(normal, axis), axis=1)
    bad = np.flatnonzero(directed & (seen <= LEAST_IN_PLANE * np.linalg.norm(axis)))
    if bad.size:
        raise InputError(
            f"axis {axis.tolist()} is zero or normal to element {bad[0]}, whose laminate's stiffness depends on the "
            "direction; expected one with a part in the surface; choose another axis"
        )


def assemble(mesh: Mesh, quads: FloatArray, trias: FloatArray, elements: BoolArray | None = None) -> sparse.csc_array:
    """Add element matrices (n_quads, 24, 24) and (n_trias, 18, 18) into one sparse matrix."""
    keep = np.ones(mesh.n_elements, dtype=bool) if elements is None else np.asarray(elements)
    if keep.shape != (mesh.n_elements,) or keep.dtype != np.bool_:
        raise InputError(
            f"elements are {keep.dtype} of shape {keep.shape}; expected ({mesh.n_elements},) booleans, one for "
            "each element; write mask == 1"
        )
    k = len(mesh.quads)
    rows, columns, values = [], [], []
    for corners, matrices, wanted in ((mesh.quads, quads, keep[:k]), (mesh.trias, trias, keep[k:])):
        dofs = dofs_of_nodes(corners[wanted]).reshape(int(wanted.sum()), matrices.shape[1]).astype(np.int32)
        rows.append(np.repeat(dofs, matrices.shape[1], axis=1).ravel())
        columns.append(np.tile(dofs, (1, matrices.shape[1])).ravel())
        values.append(matrices[wanted].ravel())
    triplets = (np.concatenate(values), (np.concatenate(rows), np.concatenate(columns)))
    return sparse.csc_array(sparse.coo_array(triplets, shape=(mesh.n_dofs, mesh.n_dofs)))
