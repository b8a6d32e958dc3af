"""A structure in one state as a VTU file for ParaView and its kin, through meshio."""

from collections.abc import Mapping
from importlib import import_module
from pathlib import Path

import numpy as np

from femlib.arrays import FloatArray
from femlib.errors import InputError, needed_by
from femlib.files import whole_file
from femlib.mesh import dofs_of_nodes
from femlib.sensors import STEEPEST, point_strain_row
from femlib.structure.model import MICRO, Structure


def write_vtu(structure: Structure, path: str | Path, state: Mapping[str, float], load: FloatArray) -> None:
    """Write the structure's mesh and motion, whole or not at all.

    Points: displacement_m, rotation_rad. Cells: stiffness_left, section (its number among the sections),
    strain_top_microstrain and strain_bottom_microstrain along the structure's axis, tension positive, NaN on beams and
    on shells across the axis.

    Raises
    ------
    InputError
        If the state or load is bad, the ending is not .vtu, or the folder cannot be written to.
    MissingExtraError
        If meshio is not installed.
    """
    target = Path(path)
    if target.suffix != ".vtu":
        raise InputError(f"picture path {target} ends in {target.suffix!r}; expected .vtu; rename it")
    with needed_by("a VTU file of a structure"):
        meshio = import_module("meshio")
    moved, built = structure.solve(state, load), structure.built
    n_quads, n_shells = len(built.mesh.quads), built.mesh.n_elements
    parts = (slice(0, n_quads), slice(n_quads, n_shells), slice(n_shells, n_shells + len(built.beams.ends)))
    top, bottom = face_strains(structure, moved)
    beams = np.full(len(built.beams.ends), np.nan)
    values = {
        "stiffness_left": structure.stiffness_left(state),
        "section": np.concatenate([built.section, len(built.laminates) + built.beams.section]).astype(np.float64),
        "strain_top_microstrain": np.concatenate([top, beams]),
        "strain_bottom_microstrain": np.concatenate([bottom, beams]),
    }
    blocks = [("quad", built.mesh.quads), ("triangle", built.mesh.trias), ("line", built.beams.ends)]
    kept = [k for k, (_, corners) in enumerate(blocks) if len(corners)]
    picture = meshio.Mesh(
        built.mesh.nodes,
        [blocks[k] for k in kept],
        point_data={"displacement_m": moved[:, :3], "rotation_rad": moved[:, 3:]},
        cell_data={name: [own[parts[k]] for k in kept] for name, own in values.items()},
    )
    with whole_file(target) as temporary:
        picture.write(temporary, file_format="vtu")


def face_strains(structure: Structure, moved: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the strain along the axis at each shell's top and bottom (n_shells,) [microstrain] of a solution."""
    built = structure.built
    mesh, axis = built.mesh, structure.axis
    normals = mesh.area_vectors()
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    seen = np.linalg.norm(np.cross(normals, axis), axis=1) > 2.0 * STEEPEST * np.linalg.norm(axis)
    faces = np.full((2, mesh.n_elements), np.nan)
    for element in np.flatnonzero(seen):
        corners = mesh.corners_of(int(element))
        own = moved.ravel()[dofs_of_nodes(corners).ravel()]
        half = built.laminates[built.section[element]].thickness / 2.0
        for face, height in zip(faces, (half, -half), strict=True):
            row = point_strain_row(mesh.nodes[corners], 0.0, 0.0, axis, height, f"element {element}")
            face[element] = MICRO * float(row @ own)
    return faces[0], faces[1]
