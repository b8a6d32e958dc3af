"""How a wing in any damage state vibrates and buckles, by the full model."""

from collections.abc import Mapping

import scipy.sparse as sparse

from femlib.arrays import FloatArray
from femlib.assembly import MOST_ERROR, BucklingMode, Mode, buckling_modes, natural_modes, point_masses
from femlib.wing.inertia import payload_masses
from femlib.wing.model import Wing


def vibrate(
    wing: Wing,
    state: Mapping[str, float],
    n_modes: int = 4,
    payload: Mapping[float, float] | None = None,
    limit: float = MOST_ERROR,
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
    limit : float
        Estimated error beyond which the frequencies are refused; by their modes' energy alone, without a finer mesh.

    Raises
    ------
    InputError
        If state, number or payload are bad.
    SolveError
        If an error is estimated beyond `limit`.
    """
    structure, factor = wing.structure, wing.structure.left_in(state)
    masses = point_masses(structure.shells.mesh, payload_masses(wing, payload))
    return natural_modes(structure.shells, structure.supports, n_modes, factor, masses, limit, is_refined=False)


def buckle(
    wing: Wing,
    state: Mapping[str, float],
    n_modes: int = 1,
    lift: FloatArray | None = None,
    limit: float = MOST_ERROR,
) -> list[BucklingMode]:
    """Return the buckling modes of a damaged wing, least load factor first; their `factor` is the load factor.

    Parameters
    ----------
    wing, state, n_modes
        As for `vibrate`.
    lift : FloatArray, optional
        Nodal forces (n_dofs,) at load factor 1 [N, N m]; the wing's own lift if not given.
    limit : float
        Estimated error beyond which the factors are refused; by their modes' energy alone, without a finer mesh.

    Raises
    ------
    InputError
        If state, number or forces are bad.
    SolveError
        If an error is estimated beyond `limit`.
    """
    structure, factor = wing.structure, wing.structure.left_in(state)
    load = wing.load(1.0, lift)
    return buckling_modes(structure.shells, structure.supports, load, n_modes, factor, limit, is_refined=False)


def mass_matrix(wing: Wing, payload: Mapping[float, float] | None = None) -> sparse.csc_array:
    """Return the mass matrix (n_dofs, n_dofs) of a wing with masses [kg] by span fraction, as `payload_masses`."""
    shells = wing.structure.shells
    return sparse.csc_array(shells.mass() + point_masses(shells.mesh, payload_masses(wing, payload)))
