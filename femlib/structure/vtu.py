"""A structure in one state as a VTU file for ParaView and its kin."""

from collections.abc import Mapping
from pathlib import Path

import numpy as np

from femlib.arrays import FloatArray
from femlib.export.vtu import middle_strains, vtu_path, write_fields
from femlib.sensors import STEEPEST
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

    Examples
    --------
    >>> import meshio
    >>> from femlib.structure.example import clamped_strip
    >>> structure = clamped_strip()
    >>> write_vtu(structure, "moved.vtu", {"root": 0.5}, structure.point_load("tip", (0.0, 0.0, 100.0)))
    >>> sorted(meshio.read("moved.vtu").point_data)
    ['displacement_m', 'rotation_rad']
    """
    target = vtu_path(path)
    moved, built = structure.solve(state, load), structure.built
    top, bottom = face_strains(structure, moved, structure.axis)
    beams = np.full(len(built.beams.ends), np.nan)
    values = {
        "stiffness_left": structure.stiffness_left(state)[: built.mesh.n_elements + len(beams)],
        "section": np.concatenate([built.section, len(built.laminates) + built.beams.section]).astype(np.float64),
        "strain_top_microstrain": np.concatenate([top, beams]),
        "strain_bottom_microstrain": np.concatenate([bottom, beams]),
    }
    points = {"displacement_m": moved[:, :3], "rotation_rad": moved[:, 3:]}
    write_fields(target, built.mesh.nodes, [built.mesh.quads, built.mesh.trias, built.beams.ends], points, values)


def face_strains(structure: Structure, moved: FloatArray, axis: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the strain along an axis (3,) at each shell's top and bottom (n_shells,) [microstrain] of a solution.

    NaN where the axis is within twice `sensors.STEEPEST` of the shell's normal.
    """
    built = structure.built
    mesh = built.mesh
    normals = mesh.area_vectors()
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    seen = np.linalg.norm(np.cross(normals, axis), axis=1) > 2.0 * STEEPEST * np.linalg.norm(axis)
    middle, slope = np.full(mesh.n_elements, np.nan), np.full(mesh.n_elements, np.nan)
    for corners, first in ((mesh.quads, 0), (mesh.trias, len(mesh.quads))):
        kept = np.flatnonzero(seen[first : first + len(corners)])
        if kept.size:
            own = moved[corners[kept]].reshape(len(kept), -1)
            middle[first + kept], slope[first + kept] = middle_strains(mesh.nodes[corners[kept]], own, axis)
    half = np.array([own.thickness for own in built.laminates])[built.section] / 2.0
    return MICRO * (middle + half * slope), MICRO * (middle - half * slope)
