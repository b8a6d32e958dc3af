"""A structure whose shells are warm: displacements and stresses under temperatures and a load.

A hindered thermal strain pushes like the forces of `femlib.assembly.thermal_load`, a damaged part in proportion to the
stiffness that it keeps. Stresses are those of the strains less the free thermal ones. Heat that buckles the shells is
refused.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from femlib.arrays import FloatArray, Judged, judged
from femlib.assembly import MOST_ERROR, BucklingMode, Stresses, buckling_modes, ply_stresses, thermal_load
from femlib.assembly.buckling import is_buckled
from femlib.assembly.peaks import MOST_PEAK_ERROR, checked_peak
from femlib.assembly.refined import MOST_UNKNOWNS
from femlib.components import damage_row
from femlib.errors import InputError, SolveError, frozen_floats, is_number
from femlib.mesh import DOFS_PER_NODE
from femlib.structure.model import Structure

Warmth = Mapping[str, tuple[float, float]]
"""Temperature [K] above the stress-free one of the middle of the shells of each set, and its rise toward their top
side [K/m]."""


@dataclass(frozen=True, slots=True, eq=False)
class Heated:
    """A warm structure.

    Attributes
    ----------
    displacements : Judged
        (n_nodes, 6) [m, rad], with their estimated error.
    stresses : Stresses
        Strains less the free thermal ones, and stresses, of all plies; their factors are on load and warmth together.

    Examples
    --------
    >>> from femlib.structure.example import clamped_strip
    >>> structure = clamped_strip()
    >>> warm = heated(structure, {"strip": (10.0, 0.0)}, strain_limit=0.1)
    >>> warm.displacements.shape, bool(warm.displacements.error < 0.03)
    ((10, 6), True)
    """

    displacements: Judged
    stresses: Stresses


def heated(
    structure: Structure,
    warmth: Warmth,
    state: Mapping[str, float] | None = None,
    load: FloatArray | None = None,
    limit: float = MOST_ERROR,
    strain_limit: float = MOST_PEAK_ERROR,
    length: float = 0.0,
) -> Heated:
    """Return the displacements and stresses of a structure with warm shells.

    Beams have no expansion, and what their forces do to buckling is left out. Beyond `MOST_UNKNOWNS` unknowns buckling
    is not looked for; `thermal_buckling` finds it.

    Parameters
    ----------
    structure : Structure
        The structure.
    warmth : mapping
        Temperature of element sets; other shells have that of the stress-free state.
    state : mapping, optional
        Named damage fractions; undamaged if not given.
    load : FloatArray, optional
        Nodal forces (n_dofs,) [N, N m] besides.
    limit : float
        Estimated error of the displacements beyond which they are refused; over the free expansion where that is more.
    strain_limit, length : float
        As for `Structure.stresses`.

    Raises
    ------
    InputError
        If a set is unknown or has no shell that expands, or a temperature, state or load is bad.
    SolveError
        If heat and load buckle the shells, or they or the strains are estimated to be farther off than allowed.

    Examples
    --------
    >>> from femlib.structure.example import clamped_strip
    >>> structure = clamped_strip()
    >>> warm = heated(structure, {"strip": (10.0, 0.0)}, strain_limit=0.1)
    >>> round(1e3 * float(warm.displacements[-1, 0]), 3)  # 4 m, 10 K, 2e-5 1/K [mm]
    0.799
    """
    shells, named = structure.built, state or {}
    left = structure.stiffness_left(named)
    warm = _warmth_of_elements(structure, warmth)
    kept = warm * left[: shells.mesh.n_elements, None]
    force = thermal_load(shells, kept[:, 0], kept[:, 1])
    push = np.zeros_like(force) if load is None else frozen_floats(load, "load", force.shape)
    moved = structure.damaged.solve(damage_row(named, structure.parameters)[None, :], force + push)[0]
    supports = structure.damaged.supports
    is_warm = np.any(moved) or np.any(warm)
    if is_warm and len(supports.free) <= MOST_UNKNOWNS and is_buckled(shells, supports, moved, left, warm):
        raise SolveError(
            "heat and load are beyond those that buckle the shells; expected less; "
            "lower the temperatures (thermal_buckling has the factor), or leave the shells room to grow"
        )
    quality = structure.judge.quality(push, moved, None, left, warm)
    quality.refuse(limit)
    error = quality.displacement_error
    off = checked_peak(structure.judge, moved, push, left, strain_limit, length, warm)
    stresses = ply_stresses(shells, moved, left, off, warmth=warm, length=length)
    return Heated(judged(moved.reshape(-1, DOFS_PER_NODE), error), stresses)


def thermal_buckling(
    structure: Structure,
    warmth: Warmth,
    state: Mapping[str, float] | None = None,
    n_modes: int = 1,
    limit: float = MOST_ERROR,
) -> list[BucklingMode]:
    """Return the buckling modes of a warm structure of shells: at `factor` times the temperatures it buckles so.

    Parameters and errors are those of `heated` and `femlib.assembly.buckling_modes`.

    >>> from femlib.structure.example import clamped_strip
    >>> structure = clamped_strip("foot", "tip")
    >>> round(thermal_buckling(structure, {"strip": (1.0, 0.0)}, limit=1.0)[0].factor, 1)  # K
    24.9
    """
    left, warm = structure.stiffness_left(state or {}), _warmth_of_elements(structure, warmth)
    supports = structure.damaged.supports
    nothing = np.zeros(supports.n_dofs)
    return buckling_modes(structure.built, supports, nothing, n_modes, left, limit, warmth=warm)


def _warmth_of_elements(structure: Structure, warmth: Warmth) -> FloatArray:
    """Return temperature and gradient of each shell (n_shells, 2)."""
    if not isinstance(warmth, Mapping):
        raise InputError(f"warmth is a {type(warmth).__name__}; expected temperatures by set name; give a mapping")
    mesh, shells = structure.mesh, structure.built
    found = np.zeros((mesh.n_shells, 2))
    expands = np.array([any(p.expansion_1 or p.expansion_2 for p in own.plies) for own in shells.laminates])
    for name, own in warmth.items():
        inside = mesh.elements_of(name)[: mesh.n_shells]
        if not isinstance(own, Sequence) or len(own) != 2 or not all(map(is_number, own)):
            raise InputError(f"warmth of {name!r} is {own!r}; expected kelvin and kelvin per metre; give two numbers")
        if not (inside & expands[shells.section]).any():
            raise InputError(
                f"warmth acts on {name!r}, where no shell expands; expected a section that does; give it an expansion"
            )
        found[inside] = own
    return found
