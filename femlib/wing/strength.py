"""What the wing bears: stresses of its plies, reactions at the root, and the greatest load factor of a damage state."""

from collections.abc import Callable, Mapping, Sequence

import numpy as np

from femlib.arrays import FloatArray, Judged, judged
from femlib.assembly import Stresses, ply_stresses, solution_quality
from femlib.assembly.stresses import Faces
from femlib.rom.capability import Capability, Limits, full_needs, reduce_capability
from femlib.wing.damage import DamageRegion
from femlib.wing.model import Wing
from femlib.wing.reduced import ReducedWing
from femlib.wing.structure import CARBON_LENGTH

FINE_STEPS = (CARBON_LENGTH / 4.0, CARBON_LENGTH / 8.0)
"""Distances of the first lines from edges on fine meshes [m]."""
TIP_LIMIT = 0.25
"""Deflection of the tip's spar that a load may cause, over the half-span; beyond it linear analysis says little."""


def wing_faces(wing: Wing) -> tuple[Faces, Faces]:
    """Return where plies are looked at: the skin at its carbon faces, the wood at its surfaces."""
    face, wood = wing.materials.face_height, 0.5 * wing.materials.wood_thickness
    return ((0, -face), (0, face)), ((0, -wood), (0, wood))


def wing_stresses(
    wing: Wing, state: Mapping[str, float], load_factor: float, lift: FloatArray | None = None
) -> Stresses:
    """Return strains and stresses at the corners of skins, web and ribs; arguments and errors as `Wing.solve`.

    Strains are means over `CARBON_LENGTH`; the stress of the skin is that of its equivalent layer. `error` is the root
    of the share of energy that is the mesh's, a mean: of the peak `wing_capability` has an error, by finer wings.
    """
    moved, factor = wing.solve(state, load_factor, lift).ravel(), wing.structure.left_in(state)
    shells = wing.structure.shells
    error = float(np.sqrt(solution_quality(shells, moved, factor).displacement_error)) if load_factor else 0.0
    return ply_stresses(shells, moved, factor, error, wing_faces(wing), length=CARBON_LENGTH)


def reactions(wing: Wing, state: Mapping[str, float], load_factor: float, lift: FloatArray | None = None) -> Judged:
    """Return the forces and moments (n_nodes, 6) [N, N m] of the root on the nodes; arguments and errors as `solve`."""
    moved = wing.solve(state, load_factor, lift).ravel()
    held = wing.structure.reactions(moved, wing.load(load_factor, lift), wing.structure.left_in(state))
    return judged(held, wing.mesh_error)


def wing_limits(wing: Wing, tip_limit: float = TIP_LIMIT, criterion: str = "max strain") -> Limits:
    """Return the limits of the wing: plies, buckling, and a deflection of the tip's spar over the half-span."""
    return Limits(wing.tip_row(), tip_limit * wing.span, criterion, wing_faces(wing), CARBON_LENGTH)


def wing_capability(
    wing: Wing,
    reduced: ReducedWing,
    limits: Limits | None = None,
    n_states: int = 300,
    n_checks: int = 6,
    finer: Callable[[tuple[DamageRegion, ...], float], Wing] | None = None,
) -> Capability:
    """Return the greatest load factors of the wing's damage states, from its reduced model.

    Parameters
    ----------
    wing, reduced
        The full model, and its reduced one under the wing's own lift.
    limits : Limits, optional
        Those of `wing_limits` if not given.
    n_states, n_checks : int
        As for `femlib.rom.capability.reduce_capability`.
    finer : callable, optional
        From regions and the distance of the first lines beside their edges [m] to the wing with these alone, such as
        `femlib.wing.built.close_wing`: plies then fail as on fine meshes. `FINE_STEPS` are asked for.
    """
    chosen = wing_limits(wing) if limits is None else limits
    meshes = (
        None if finer is None else lambda own, damages: _needs(finer, [wing.regions[k] for k in own], damages, chosen)
    )
    return reduce_capability(wing.structure, reduced.model, chosen, wing.lift, n_states, n_checks, finer=meshes)


def _needs(
    finer: Callable[[tuple[DamageRegion, ...], float], Wing],
    regions: Sequence[DamageRegion],
    damages: FloatArray,
    limits: Limits,
) -> list[FloatArray]:
    wings = (finer(tuple(regions), step) for step in FINE_STEPS)
    return [full_needs(own.structure, wing_limits(own, criterion=limits.criterion), own.lift, damages) for own in wings]
