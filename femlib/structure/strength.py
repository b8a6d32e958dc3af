"""What a structure of the user's own bears: the capability of the wing (`femlib.rom.capability`) by set names."""

from collections.abc import Sequence

import numpy as np
import scipy.sparse as sparse

from femlib.arrays import FloatArray
from femlib.components import DamagedStructure
from femlib.errors import InputError, frozen_floats
from femlib.mesh import DOFS_PER_NODE
from femlib.rom import ReductionSettings, reduce_structure
from femlib.rom.capability import Capability, Limits, reduce_capability
from femlib.structure.named_mesh import NamedMesh

OUTPUTS = ("deflection", "work")
"""What the reduced model is made exact for: the limited deflection, and the displacements as a whole."""


def structure_limits(
    mesh: NamedMesh, place: str, direction: Sequence[float], most: float, criterion: str = "max strain"
) -> Limits:
    """Return the limits: plies, buckling, and the mean motion of a node set along a direction (3,) [m].

    Raises
    ------
    InputError
        If there is no such set or criterion, the direction is zero, or `most` is not above 0.
    """
    along = frozen_floats(direction, "direction", (3,))
    length = float(np.linalg.norm(along))
    if not length > 0.0:
        raise InputError(f"direction of the deflection is {along.tolist()}; expected a vector other than 0; give one")
    nodes = mesh.nodes_of(place)
    row = np.zeros((len(mesh.nodes), DOFS_PER_NODE))
    row[nodes, :3] = along / length / len(nodes)
    return Limits(row.ravel(), most, criterion)


def structure_capability(
    damaged: DamagedStructure,
    load: FloatArray,
    limits: Limits,
    settings: ReductionSettings | None = None,
    n_states: int = 300,
    n_checks: int = 6,
) -> Capability:
    """Return the greatest factors on a load (n_dofs,) [N, N m]; arguments as those of `reduce_capability`.

    Raises
    ------
    InputError
        If there is no damage region, a beam or a spring, the load is 0, or a ply has no strength.
    """
    if not damaged.components:
        raise InputError("the structure has no damage region; expected at least one; name element sets in damage")
    force = frozen_floats(load, "load", (damaged.shells.mesh.n_dofs,))
    if not force.any():
        raise InputError("the load is 0; expected forces, whose factor is asked for; give a load")
    rows = sparse.csr_array(np.stack([limits.row, force]))
    model = reduce_structure(damaged, force, rows, OUTPUTS, settings, with_motion=True)
    return reduce_capability(damaged, model, limits, force, n_states, n_checks)
