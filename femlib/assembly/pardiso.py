"""Factors by oneMKL's PARDISO (extra `pardiso`): quicker on fine meshes, not exact to the same last digits."""

from dataclasses import dataclass
from typing import Any

import numpy as np
import scipy.sparse as sparse

from femlib.arrays import FloatArray
from femlib.errors import SolveError, needed_by

POSITIVE_DEFINITE = 2
"""PARDISO's matrix type: real, symmetric, positive definite; it wants the upper triangle."""


@dataclass(frozen=True, slots=True, eq=False)
class PardisoFactors:
    """Factors of a symmetric positive definite matrix in PARDISO's own order; memory is freed with the object."""

    solver: Any
    upper: Any

    @classmethod
    def of(cls, matrix: sparse.csc_array) -> "PardisoFactors":
        """Return the factors of a symmetric positive definite matrix (n, n).

        Raises
        ------
        MissingExtraError
            If pypardiso is not installed.
        SolveError
            If the matrix is not positive definite, as that of a structure which can still move.
        """
        with needed_by("solver 'pardiso'"):
            import pypardiso
        solver = pypardiso.PyPardisoSolver(mtype=POSITIVE_DEFINITE)
        upper = sparse.csr_matrix(sparse.triu(matrix, format="csr"))
        try:
            solver.factorize(upper)
        except pypardiso.pardiso_wrapper.PyPardisoError as error:
            raise SolveError(
                f"stiffness of {matrix.shape[0]} degrees of freedom is not positive definite ({error}); "
                "expected a supported structure; hold its rigid motions"
            ) from error
        return cls(solver, upper)

    def solve(self, right: FloatArray) -> FloatArray:
        """Return x of A x = right, (n,) or (n, k)."""
        solution = self.solver.solve(self.upper, np.asfortranarray(right))
        return np.asarray(solution, dtype=np.float64).reshape(right.shape)

    def __del__(self) -> None:
        self.solver.free_memory(everything=True)
