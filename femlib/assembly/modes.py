"""Natural frequencies of a supported structure: K phi = omega^2 M phi.

Each is compared with that of the structure on a finer mesh (`refined`); where that would be too large its error is half
the share of the mode's energy that is the mesh's (`quality`).

Source: R. B. Lehoucq, D. C. Sorensen, C. Yang, ARPACK Users' Guide (1998), shift-invert mode about zero.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
import scipy.sparse as sparse
from scipy.sparse.linalg import ArpackError, LinearOperator, eigsh

from femlib.arrays import FloatArray
from femlib.assembly.factors import factorise
from femlib.assembly.quality import MOST_ERROR, refuse_error, solution_quality
from femlib.assembly.refined import Refined
from femlib.assembly.shells import Shells
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
    error : float
        Estimated relative error of the frequency by the mesh; NaN if it was found of matrices alone.
    """

    frequency: float
    shape: FloatArray
    error: float = float("nan")


def natural_modes(
    shells: Shells,
    supports: Supports,
    n_modes: int,
    factor: FloatArray | None = None,
    masses: sparse.csc_array | None = None,
    limit: float = MOST_ERROR,
    is_refined: bool = True,
) -> list[Mode]:
    """Return the lowest modes of a structure, lowest first, each with an estimate of its frequency's error.

    Parameters
    ----------
    shells, supports
        The structure.
    n_modes : int
        How many.
    factor : FloatArray, optional
        Factor on each part's stiffness (n_parts,), for damage.
    masses : csc_array, optional
        Masses besides the parts' (n_dofs, n_dofs), such as `point_masses`.
    limit : float
        Estimated error beyond which they are refused.
    is_refined : bool
        Whether to compare with a finer mesh where it is small enough.

    Raises
    ------
    InputError
        If the number of modes is none that the structure has.
    SolveError
        If the structure can move freely, the iteration does not converge, or an error is estimated beyond `limit`.
    """
    modes = matrix_modes(shells.stiffness(factor=factor), _mass(shells, masses), supports, n_modes)
    finer = Refined.finest(shells, supports) if is_refined else None
    if finer is None:
        errors = [0.5 * solution_quality(shells, mode.shape, factor).displacement_error for mode in modes]
    else:
        stiffness = finer.shells.stiffness(factor=finer.factor(factor))
        fine = matrix_modes(stiffness, _mass(finer.shells, masses), finer.supports, n_modes)
        pairs = zip(modes, fine, strict=True)
        errors = [finer.share * abs(own.frequency / other.frequency - 1.0) for own, other in pairs]
    refuse_error(max(errors), "natural frequencies", limit)
    return [replace(mode, error=error) for mode, error in zip(modes, errors, strict=True)]


def _mass(shells: Shells, masses: sparse.csc_array | None) -> sparse.csc_array:
    """Return the mass matrix (n_dofs, n_dofs) with masses that may be of fewer nodes, the first ones."""
    own = shells.mass()
    if masses is None:
        return own
    added = sparse.coo_array(masses)
    return sparse.csc_array(own + sparse.coo_array((added.data, (added.row, added.col)), shape=own.shape))


def matrix_modes(stiffness: sparse.csc_array, mass: sparse.csc_array, supports: Supports, n_modes: int) -> list[Mode]:
    """Return the lowest modes of matrices over all degrees of freedom (n_dofs, n_dofs), lowest first, not judged.

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
