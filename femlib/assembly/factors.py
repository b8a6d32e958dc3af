"""Factors of a stiffness matrix, with chosen unknowns eliminated last.

By SuiteSparse's CHOLMOD where scikit-sparse is installed (extra `cholmod`), else by scipy's SuperLU, unless
`factored_by` says otherwise.
"""

from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass
from functools import cache
from importlib.util import find_spec

import numpy as np
import scipy.sparse as sparse
from scipy.sparse.linalg import SuperLU, splu

from femlib.arrays import FloatArray, IntArray
from femlib.assembly.cholmod import CholmodFactors
from femlib.errors import InputError, SolveError

SOLVERS = ("superlu", "cholmod")
SINGULAR = 1e13
"""Growth of a right side, both scaled by the diagonal's roots, beyond which a matrix counts as singular. A cantilever
3,750 times as long as thick: 1e10; an unsupported plate: 1e15."""
_SOLVER: ContextVar[str | None] = ContextVar("solver", default=None)


@cache
def default_solver() -> str:
    """Return the solver outside `factored_by`."""
    return "superlu" if find_spec("sksparse") is None else "cholmod"


@contextmanager
def factored_by(solver: str) -> Iterator[None]:
    """Factorise with "superlu" or "cholmod" (an extra) inside the block.

    Raises
    ------
    InputError
        If there is no such solver.
    """
    if solver not in SOLVERS:
        raise InputError(f"solver is {solver!r}; expected one of {list(SOLVERS)}; correct it")
    token = _SOLVER.set(solver)
    try:
        yield
    finally:
        _SOLVER.reset(token)


@dataclass(frozen=True, slots=True, eq=False)
class Factors:
    """Factors of a symmetric positive definite matrix, eliminated with chosen rows ("ports") last.

    Attributes
    ----------
    lu : SuperLU or CholmodFactors
        Factors of the reordered matrix.
    order : IntArray
        Row k of the reordered matrix is row order[k] (n,); the ports are its last entries.
    ports : IntArray
        The rows eliminated last (n_ports,).
    """

    lu: SuperLU | CholmodFactors
    order: IntArray
    ports: IntArray

    def solve(self, right: FloatArray) -> FloatArray:
        """Return x of A x = right, (n,) or (n, k)."""
        solution = np.empty_like(right)
        solution[self.order] = self.lu.solve(right[self.order])
        return solution

    def has_negative_pivot(self) -> bool:
        """Return whether SuperLU met a negative pivot: the symmetric matrix is then not positive definite."""
        if not isinstance(self.lu, SuperLU):
            raise SolveError("only SuperLU's factors show pivots; expected those; factorise with definite=False")
        return bool((self.lu.U.diagonal() < 0.0).any())

    def schur(self) -> FloatArray:
        """Return the Schur complement on the ports (n_ports, n_ports): the last block of L times that of U or L'.

        It costs nothing beyond the factorisation; solving for the flexibility at 400 ports took three times as long.
        """
        n, n_ports = len(self.order), len(self.ports)
        if isinstance(self.lu, CholmodFactors):
            return self.lu.last_block(n_ports)
        rows, columns = self.lu.perm_r[n - n_ports :], self.lu.perm_c[n - n_ports :]
        first = n - n_ports
        if n_ports and (rows.min() < first or columns.min() < first):
            raise SolveError(
                f"{n_ports} ports were not eliminated last; expected a structure in one piece; connect its parts"
            )
        lower, upper = self.lu.L[first:, first:], self.lu.U[first:, first:]
        block = (lower @ upper).toarray()[rows - first][:, columns - first]
        return np.asarray(0.5 * (block + block.T))


def factorise(
    matrix: sparse.csc_array, groups: IntArray, ports: IntArray | None = None, definite: bool = True
) -> Factors:
    """Return the factors of a symmetric matrix (n, n).

    Parameters
    ----------
    matrix : csc_array
        The matrix.
    groups : IntArray
        Node of each row (n,). The order of elimination (minimum degree) is found on the nodes' graph, 36 times smaller.
    ports : IntArray, optional
        Rows to eliminate last.
    definite : bool
        Whether it is positive definite; if that is not known, as of a tangent far from equilibrium, SuperLU takes it.

    Raises
    ------
    SolveError
        If the matrix is singular, as that of a structure which can still move.
    InputError
        If CHOLMOD is asked for and not installed.
    """
    last = np.zeros(0, dtype=np.int64) if ports is None else ports
    if len(groups) != matrix.shape[0]:
        raise InputError(
            f"groups name the nodes of {len(groups)} rows but the matrix has {matrix.shape[0]}; expected one for each; "
            "take those of its Supports"
        )
    solver = (_SOLVER.get() or default_solver()) if definite else "superlu"
    if solver == "cholmod":
        lu, order = CholmodFactors.of(matrix, last)
        return _checked(Factors(lu, order, last), matrix)
    rank = _minimum_degree(matrix, groups)[groups]
    rank[last] = rank.max(initial=0) + 1
    inner = np.argsort(rank, kind="stable")[: len(rank) - len(last)]
    order = np.concatenate([inner, last])
    reordered = sparse.csc_array(matrix[order][:, order])
    if len(last):
        reordered = _with_full_block(reordered, len(last))
    try:
        superlu = splu(reordered, permc_spec="NATURAL", diag_pivot_thresh=0.0, options={"SymmetricMode": True})
    except RuntimeError as error:
        raise SolveError(
            f"stiffness of {matrix.shape[0]} degrees of freedom is singular ({error}); "
            "expected a supported structure; hold its rigid motions"
        ) from error
    return _checked(Factors(superlu, order, last), matrix)


def _checked(factors: Factors, matrix: sparse.csc_array) -> Factors:
    """Return the factors after checking on one right side that the matrix is positive definite and not singular."""
    root = np.sqrt(np.maximum(matrix.diagonal(), 0.0))
    right = root * np.cos(np.arange(len(root), dtype=np.float64))  # any vector that no motion is normal to
    found = factors.solve(right)
    growth = float(np.linalg.norm(root * found)) / float(np.sqrt(len(root)))
    if not growth <= SINGULAR:
        raise SolveError(
            f"stiffness of {len(root)} degrees of freedom is singular to rounding (a right side grows {growth:.1g} "
            "times); expected a structure in one piece that is held; hold its rigid motions, and check thicknesses "
            "and units"
        )
    return factors


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
