"""How a wing in any damage state vibrates and buckles, by the full model."""

from collections.abc import Mapping

import scipy.sparse as sparse

from femlib.arrays import FloatArray
from femlib.assembly import BucklingMode, Mode, buckling_modes, geometric_stiffness, natural_modes, point_masses
from femlib.wing.bent import stiffness_factor
from femlib.wing.inertia import payload_masses
from femlib.wing.model import Wing


def vibrate(
    wing: Wing, state: Mapping[str, float], n_modes: int = 4, payload: Mapping[float, float] | None = None
) -> list[Mode]:
    """Return the lowest natural modes of a damaged wing, lowest first.

    Parameters
    ----------
    wing : Wing
        The wing.
    state : mapping
        Damage fractions by parameter; damage takes stiffness and no mass.
    n_modes : int
        How many.
    payload : mapping, optional
        Masses [kg] by span fraction, on the spar.

    Raises
    ------
    InputError
        If state, number or payload are bad.
    """
    structure = wing.structure
    stiffness = structure.shells.stiffness(factor=stiffness_factor(wing, state))
    return natural_modes(stiffness, mass_matrix(wing, payload), structure.supports, n_modes)


def buckle(
    wing: Wing, state: Mapping[str, float], n_modes: int = 1, lift: FloatArray | None = None
) -> list[BucklingMode]:
    """Return the buckling modes of a damaged wing, least load factor first; their `factor` is the load factor.

    Parameters
    ----------
    wing, state, n_modes
        As for `vibrate`.
    lift : FloatArray, optional
        Nodal forces (n_dofs,) at load factor 1 [N, N m]; the wing's own lift if not given.

    Raises
    ------
    InputError
        If state, number or forces are bad.
    """
    structure, factor = wing.structure, stiffness_factor(wing, state)
    moved = wing.solve(state, 1.0, lift).ravel()
    stressed = geometric_stiffness(structure.shells, moved, factor)
    return buckling_modes(structure.shells.stiffness(factor=factor), stressed, structure.supports, n_modes)


def mass_matrix(wing: Wing, payload: Mapping[float, float] | None = None) -> sparse.csc_array:
    """Return the mass matrix (n_dofs, n_dofs) of a wing with masses [kg] by span fraction, as `payload_masses`."""
    shells = wing.structure.shells
    return sparse.csc_array(shells.mass() + point_masses(shells.mesh, payload_masses(wing, payload)))
