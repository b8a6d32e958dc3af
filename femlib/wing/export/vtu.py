"""A state of the wing as a VTU file, for ParaView and its kin."""

from collections.abc import Mapping
from pathlib import Path

import numpy as np

from femlib.arrays import FloatArray
from femlib.assembly import Deflection
from femlib.export.vtu import middle_strains, vtu_path, write_fields
from femlib.mesh import dofs_of_nodes
from femlib.wing.bent import bend
from femlib.wing.gauges import SPANWISE
from femlib.wing.model import MICRO, Wing


def write_vtu(
    wing: Wing,
    path: str | Path,
    state: Mapping[str, float],
    load_factor: float,
    lift: FloatArray | None = None,
    large_deflection: bool = False,
) -> None:
    """Write mesh, displacement [m], spanwise strain [microstrain, compressive positive] and patch, whole or not at all.

    The strain is that of the outer face at each quadrilateral's centre, NaN on ribs. `lift` (n_dofs,) are other nodal
    forces at load factor 1 [N, N m].

    Raises
    ------
    InputError
        If the state is bad, the ending is not .vtu, or the folder cannot be written to.
    """
    target = vtu_path(path)
    mesh = wing.structure.shells.mesh
    if large_deflection:
        moved, strains = far_shape(wing, bend(wing, state, load_factor, lift).deflection)
    else:
        moved, strains = near_shape(wing, wing.solve(state, load_factor, lift))
    cells = {
        "spanwise_strain_microstrain": strains,
        "patch": mesh.patch_of_element.astype(np.float64),
    }
    write_fields(target, mesh.nodes, [mesh.quads, mesh.trias], {"displacement_m": moved}, cells)


def near_shape(wing: Wing, moved: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return displacements (n_nodes, 3) [m] and face strains (n_elements,) [microstrain] of a solution (n_nodes, 6)."""
    quads = wing.structure.shells.mesh.quads
    return moved[:, :3], face_strains(wing, moved.ravel()[dofs_of_nodes(quads)].reshape(len(quads), -1))


def far_shape(wing: Wing, deflection: Deflection) -> tuple[FloatArray, FloatArray]:
    """Return the same of a large deflection."""
    mesh = wing.structure.shells.mesh
    return deflection.displacement, face_strains(wing, deflection.deformation(mesh, mesh.quads))


def face_strains(wing: Wing, deformation: FloatArray) -> FloatArray:
    """Return the spanwise strain of each element's outer face at its centre (n_elements,) [microstrain], NaN on ribs.

    `deformation` (n_quads, 24) are the quadrilaterals' displacements without rigid motion, or whole if that is small.
    """
    mesh = wing.structure.shells.mesh
    strains = np.full(mesh.n_elements, np.nan)
    across = mesh.patch_of_element == mesh.patches.index("ribs")
    kept = np.flatnonzero(~across[: len(mesh.quads)])
    middle, slope = middle_strains(mesh.nodes[mesh.quads[kept]], deformation[kept], SPANWISE)
    height = np.where(wing.structure.shells.section[kept] == 0, wing.materials.face_height, 0.0)
    strains[kept] = -MICRO * (middle + height * slope)
    return strains
