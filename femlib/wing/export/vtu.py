"""A state of the wing as a VTU file, for ParaView and its kin.

Source: The VTK User's Guide (2010), XML unstructured grids, ASCII. Written here in thirty lines instead of through
meshio, whose last release is of January 2024: meshio 5.3.5 and VTK read the files.
"""

from collections.abc import Mapping
from pathlib import Path

import numpy as np

from femlib.arrays import FloatArray, IntArray
from femlib.assembly import Deflection
from femlib.errors import InputError
from femlib.files import whole_file
from femlib.mesh import dofs_of_nodes
from femlib.sensors import point_strain_row
from femlib.wing.bent import bend
from femlib.wing.gauges import SPANWISE
from femlib.wing.model import MICRO, Wing

QUAD, TRIANGLE = 9, 5
"""The format's numbers of the two shapes."""


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
    target = Path(path)
    if target.suffix != ".vtu":
        raise InputError(f"picture path {target} ends in {target.suffix!r}; expected .vtu; rename it")
    mesh = wing.structure.shells.mesh
    if large_deflection:
        moved, strains = far_shape(wing, bend(wing, state, load_factor, lift).deflection)
    else:
        moved, strains = near_shape(wing, wing.solve(state, load_factor, lift))
    cells = {
        "spanwise_strain_microstrain": strains,
        "patch": mesh.patch_of_element.astype(np.float64),
    }
    text = _document(mesh.nodes, [mesh.quads, mesh.trias], {"displacement_m": moved}, cells)
    with whole_file(target) as temporary:
        temporary.write_text(text, encoding="ascii")


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
    for element in np.flatnonzero(~across[: len(mesh.quads)]):
        height = wing.materials.face_height if wing.structure.shells.section[element] == 0 else 0.0
        corners = mesh.nodes[mesh.quads[element]]
        row = point_strain_row(corners, 0.0, 0.0, SPANWISE, height, f"element {element}")
        strains[element] = -MICRO * float(row @ deformation[element])
    return strains


def _document(
    nodes: FloatArray, shapes: list[IntArray], points: dict[str, FloatArray], cells: dict[str, FloatArray]
) -> str:
    sizes = np.concatenate([np.full(len(corners), corners.shape[1]) for corners in shapes])
    kinds = np.where(sizes == 4, QUAD, TRIANGLE)
    joined = np.concatenate([corners.ravel() for corners in shapes])
    lines = [
        '<?xml version="1.0"?>',
        '<VTKFile type="UnstructuredGrid" version="0.1" byte_order="LittleEndian"><UnstructuredGrid>',
        f'<Piece NumberOfPoints="{len(nodes)}" NumberOfCells="{len(sizes)}">',
        "<Points>",
        _array("points", nodes, "Float64"),
        "</Points><Cells>",
        _array("connectivity", joined, "Int64"),
        _array("offsets", np.cumsum(sizes), "Int64"),
        _array("types", kinds, "UInt8"),
        "</Cells><PointData>",
        *(_array(name, values, "Float64") for name, values in points.items()),
        "</PointData><CellData>",
        *(_array(name, values, "Float64") for name, values in cells.items()),
        "</CellData></Piece></UnstructuredGrid></VTKFile>",
    ]
    return "\n".join(lines) + "\n"


def _array(name: str, values: FloatArray | IntArray, kind: str) -> str:
    width = values.shape[1] if values.ndim == 2 else 1
    words = " ".join(f"{v:.9g}" for v in values.ravel())
    return f'<DataArray type="{kind}" Name="{name}" NumberOfComponents="{width}" format="ascii">\n{words}\n</DataArray>'
