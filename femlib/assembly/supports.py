"""Supports: degrees of freedom held at zero."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import scipy.sparse as sparse

from femlib.arrays import FloatArray, IntArray
from femlib.errors import InputError
from femlib.mesh import DOFS_PER_NODE, Mesh, dofs_of_nodes


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
