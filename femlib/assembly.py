"""From elements to the system K u = f: assembly, supports, factorisation and consistent loads."""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
import scipy.sparse as sparse
from scipy.sparse.linalg import SuperLU, splu

from femlib.arrays import BoolArray, FloatArray, IntArray
from femlib.elements import quad4, tria3
from femlib.errors import InputError, SolveError, frozen_floats, frozen_ints
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
    """

    mesh: Mesh
    laminates: tuple[Laminate, ...]
    section: IntArray
    scale: FloatArray
    axis: FloatArray
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


@dataclass(frozen=True, slots=True, eq=False)
class Supports:
    """Which degrees of freedom are held at zero.

    Attributes
    ----------
    n_dofs : int
        All degrees of freedom.
    free : IntArray
        Those that move.
    """

    n_dofs: int
    free: IntArray

    @classmethod
    def holding(cls, mesh: Mesh, held: Sequence[int] | IntArray) -> "Supports":
        """Hold the degrees of freedom `held`.

        Raises
        ------
        InputError
            If a number is outside the mesh or nothing is held.
        """
        numbers = np.unique(np.asarray(held, dtype=np.int64))
        if numbers.size == 0 or numbers[0] < 0 or numbers[-1] >= mesh.n_dofs:
            raise InputError(
                f"supports name {numbers.size} degrees of freedom, not all in 0 to {mesh.n_dofs - 1}; "
                "hold at least six in the mesh"
            )
        return cls(mesh.n_dofs, np.setdiff1d(np.arange(mesh.n_dofs), numbers))

    @classmethod
    def clamping(cls, mesh: Mesh, nodes: IntArray) -> "Supports":
        """Hold all six degrees of freedom of `nodes`."""
        return cls.holding(mesh, dofs_of_nodes(nodes).ravel())

    def reduce(self, matrix: sparse.csc_array) -> sparse.csc_array:
        """Return the rows and columns that move."""
        return sparse.csc_array(matrix[self.free][:, self.free])

    def expand(self, values: FloatArray) -> FloatArray:
        """Return (n_dofs, ...) with zeros at the supports from (n_free, ...)."""
        full = np.zeros((self.n_dofs, *values.shape[1:]))
        full[self.free] = values
        return full


@dataclass(frozen=True, slots=True, eq=False)
class Factors:
    """Factors of a symmetric positive definite matrix, eliminated with chosen rows ("ports") last.

    Attributes
    ----------
    lu : SuperLU
        Factors of the reordered matrix.
    order : IntArray
        Row k of the reordered matrix is row order[k] (n,); the ports are its last entries.
    ports : IntArray
        The rows eliminated last (n_ports,).
    """

    lu: SuperLU
    order: IntArray
    ports: IntArray

    def solve(self, right: FloatArray) -> FloatArray:
        """Return x of A x = right, (n,) or (n, k)."""
        solution = np.empty_like(right)
        solution[self.order] = self.lu.solve(right[self.order])
        return solution

    def schur(self) -> FloatArray:
        """Return the Schur complement on the ports (n_ports, n_ports): the last block of L times that of U.

        It costs nothing beyond the factorisation; solving for the flexibility at 400 ports took three times as long.
        """
        n, n_ports = len(self.order), len(self.ports)
        rows, columns = self.lu.perm_r[n - n_ports :], self.lu.perm_c[n - n_ports :]
        first = n - n_ports
        if n_ports and (rows.min() < first or columns.min() < first):
            raise SolveError(
                f"{n_ports} ports were not eliminated last; expected a structure in one piece; connect its parts"
            )
        lower, upper = self.lu.L[first:, first:], self.lu.U[first:, first:]
        block = (lower @ upper).toarray()[rows - first][:, columns - first]
        return np.asarray(0.5 * (block + block.T))


def factorise(matrix: sparse.csc_array, groups: IntArray, ports: IntArray | None = None) -> Factors:
    """Return the factors of a symmetric positive definite matrix (n, n).

    Parameters
    ----------
    matrix : csc_array
        The matrix.
    groups : IntArray
        Node of each row (n,). The order of elimination (minimum degree) is found on the nodes' graph, 36 times smaller.
    ports : IntArray, optional
        Rows to eliminate last.

    Raises
    ------
    SolveError
        If the matrix is singular, as that of a structure which can still move.
    """
    last = np.zeros(0, dtype=np.int64) if ports is None else ports
    rank = _minimum_degree(matrix, groups)[groups]
    rank[last] = rank.max(initial=0) + 1
    inner = np.argsort(rank, kind="stable")[: len(rank) - len(last)]
    order = np.concatenate([inner, last])
    reordered = sparse.csc_array(matrix[order][:, order])
    if len(last):
        reordered = _with_full_block(reordered, len(last))
    try:
        lu = splu(reordered, permc_spec="NATURAL", diag_pivot_thresh=0.0, options={"SymmetricMode": True})
    except RuntimeError as error:
        raise SolveError(
            f"stiffness of {matrix.shape[0]} degrees of freedom is singular ({error}); "
            "expected a supported structure; hold its rigid motions"
        ) from error
    return Factors(lu, order, last)


def _minimum_degree(matrix: sparse.csc_array, groups: IntArray) -> IntArray:
    """Return the position of each node in a fill-reducing order (n_nodes,)."""
    n = matrix.shape[0]
    gather = sparse.csc_array((np.ones(n), (np.arange(n), groups)))
    graph = sparse.csc_array(gather.T @ abs(matrix) @ gather)
    graph.data[:] = -1.0
    degrees = np.diff(graph.indptr) + 1.0
    laplacian = sparse.csc_array(graph + sparse.diags_array(degrees + 1.0))
    options = {"SymmetricMode": True}
    return splu(laplacian, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options=options).perm_c.astype(np.int64)


def _with_full_block(matrix: sparse.csc_array, n_last: int) -> sparse.csc_array:
    """Store zeros in the last diagonal block, so that no postordering moves its rows forward."""
    first = matrix.shape[0] - n_last
    rows, columns = (index.ravel() + first for index in np.indices((n_last, n_last)))
    entries = sparse.coo_array(matrix)
    joined = sparse.coo_array(
        (
            np.concatenate([entries.data, np.zeros(n_last * n_last)]),
            (np.concatenate([entries.row, rows]), np.concatenate([entries.col, columns])),
        ),
        shape=matrix.shape,
    )
    return sparse.csc_array(joined)
