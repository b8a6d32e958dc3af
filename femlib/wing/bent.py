"""The wing bent far: gauge strains and displacements with large deflection.

The model of `femlib.wing.model` is linear in load; this one follows the bent shape by `femlib.assembly.deflect`. The
forces keep their directions, as lift that stays vertical does.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from femlib.arrays import FloatArray
from femlib.assembly import Deflection, deflect
from femlib.assembly.loads import thermal_forces
from femlib.errors import InputError, is_whole
from femlib.wing.model import MICRO, Wing


@dataclass(frozen=True, slots=True, eq=False)
class BentWing:
    """A wing in equilibrium on its bent shape.

    Attributes
    ----------
    deflection : Deflection
        Displacements and rotations of the nodes.
    strain_microstrain : FloatArray
        Gauge strains (n_gauges,), compressive positive, at the given load.
    tip : FloatArray
        Displacement (3,) of the spar's tip [m]: x aft, y outboard, z up.
    """

    deflection: Deflection
    strain_microstrain: FloatArray
    tip: FloatArray


def bend(
    wing: Wing,
    state: Mapping[str, float],
    load_factor: float,
    lift: FloatArray | None = None,
    warming: float | FloatArray = 0.0,
    gradient: float | FloatArray = 0.0,
    steps: int = 1,
) -> BentWing:
    """Return the wing with large deflection, solved by Newton's method.

    Parameters
    ----------
    wing : Wing
        The wing.
    state : mapping
        Damage fractions by parameter.
    load_factor : float
        Factor on the forces.
    lift : FloatArray, optional
        Nodal forces (n_dofs,) at load factor 1 [N, N m]; the elliptic lift if not given.
    warming : float or FloatArray
        Temperature above the stress-free state, of all or of each element (n_elements,) [K].
    gradient : float or FloatArray
        Temperature per height toward each element's top side [K/m].
    steps : int
        Equal load steps; one suffices for any load that the wing's skin bears.

    Raises
    ------
    InputError
        If state, load factor or forces are bad.
    SolveError
        If no equilibrium is found.
    """
    structure, n = wing.structure, wing.structure.shells.mesh.n_elements
    if not is_whole(steps) or steps < 1:
        raise InputError(f"steps is {steps!r}; expected 1 or more load steps; correct it")
    for name, field in (("warming", warming), ("gradient", gradient)):
        if np.shape(field) not in ((), (n,)):
            raise InputError(f"{name} has shape {np.shape(field)}; expected one number or ({n},), one an element")
    factor = wing.structure.left_in(state)
    thermal = thermal_forces(structure.shells, np.broadcast_to(warming, n), np.broadcast_to(gradient, n))
    load = wing.load(load_factor, lift)
    fractions = (np.arange(steps) + 1.0) / steps
    last = deflect(structure.shells, structure.supports, load, fractions.tolist(), factor, thermal)[-1]
    tip = wing.grid.columns(len(wing.grid.eta) - 1)[wing.grid.spar_column]
    return BentWing(last, gauge_strains(wing, last), last.displacement[tip].mean(axis=0))


def gauge_strains(wing: Wing, deflection: Deflection) -> FloatArray:
    """Return the strains (n_gauges,) [microstrain, compressive positive] of a deflection."""
    mesh = wing.structure.shells.mesh
    strains = []
    for parts in wing.element_rows:
        elements = np.array(list(parts))
        deformation = deflection.deformation(mesh, mesh.quads[elements])
        strains.append(float(np.sum(np.stack(list(parts.values())) * deformation)))
    return -MICRO * np.array(strains)
