"""Natural frequencies of a supported structure: K phi = omega^2 M phi.

Source: R. B. Lehoucq, D. C. Sorensen, C. Yang, ARPACK Users' Guide (1998), shift-invert mode about zero.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import scipy.sparse as sparse
from scipy.sparse.linalg import ArpackError, LinearOperator, eigsh

from femlib.arrays import FloatArray
from femlib.assembly.factors import factorise
from femlib.assembly.supports import Supports
from femlib.errors import InputError, SolveError, is_number, is_whole
from femlib.mesh import DOFS_PER_NODE, Mesh


@dataclass(frozen=True, slots=True, eq=False)
class Mode:
    """A natural mode.

    Attributes
    ----------
    frequency : float
        Frequency [Hz].
    shape : FloatArray
        Displacements (n_dofs,), scaled to a modal mass of 1 kg.
    """

    frequency: float
    shape: FloatArray


def natural_modes(stiffness: sparse.csc_array, mass: sparse.csc_array, supports: Supports, n_modes: int) -> list[Mode]:
    """Return the lowest modes of matrices over all degrees of freedom (n_dofs, n_dofs), lowest first.

    Raises
    ------
    InputError
        If the number of modes is none that the structure has.
    SolveError
        If the structure can move freely or the iteration does not converge.
    """
    if not is_whole(n_modes) or not 1 <= n_modes < len(supports.free) - 1:
        raise InputError(f"n_modes is {n_modes!r}; expected 1 to {len(supports.free) - 2}; correct it")
    held, heavy = supports.reduce(stiffness), supports.reduce(mass)
    factors = factorise(held, supports.groups)
    inverse = LinearOperator(held.shape, matvec=factors.solve, dtype=np.float64)
    # a fixed start vector makes the result the same in every run
    start = np.ones(held.shape[0])
    try:
        squares, shapes = eigsh(held, n_modes, M=heavy, sigma=0.0, OPinv=inverse, v0=start)
    except ArpackError as error:
        raise SolveError(f"{n_modes} natural modes did not converge ({error}); ask for fewer") from error
    order = np.argsort(squares)
    return [Mode(float(np.sqrt(squares[k]) / (2.0 * np.pi)), supports.expand(shapes[:, k])) for k in order]


def point_masses(mesh: Mesh, masses: Mapping[int, float]) -> sparse.csc_array:
    """Return the mass matrix (n_dofs, n_dofs) of point masses [kg] at nodes, without rotary inertia.

    Raises
    ------
    InputError
        If a node is missing or a mass is negative.
    """
    diagonal = np.zeros(mesh.n_dofs)
    if not isinstance(masses, Mapping):
        raise InputError(f"point masses are {masses!r}; expected masses by node; write {{12: 0.17}}")
    for node, mass in masses.items():
        if not is_whole(node) or not 0 <= node < len(mesh.nodes) or not is_number(mass) or mass < 0.0:
            raise InputError(
                f"point mass {mass!r} kg at node {node}; expected 0 kg or more at a node "
                f"from 0 to {len(mesh.nodes) - 1}; correct it"
            )
        diagonal[DOFS_PER_NODE * node : DOFS_PER_NODE * node + 3] += mass
    return sparse.csc_array(sparse.diags_array(diagonal))
