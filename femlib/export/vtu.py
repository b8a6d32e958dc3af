"""A mesh with fields as a VTU file, for ParaView and its kin.

Source: The VTK User's Guide (2010), XML unstructured grids, ASCII. Written here in thirty lines instead of through
meshio, whose last release is of January 2024: meshio 5.3.5 and VTK read the files.
"""

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from femlib.arrays import FloatArray, IntArray
from femlib.elements import quad4, tria3
from femlib.errors import InputError
from femlib.files import whole_file

SHAPES = {2: 3, 3: 5, 4: 9}
"""The format's numbers of a line, a triangle and a quadrilateral, by their corners."""


def vtu_path(path: str | Path) -> Path:
    """Return a path of a VTU file; InputError if it ends otherwise."""
    target = Path(path)
    if target.suffix != ".vtu":
        raise InputError(f"picture path {target} ends in {target.suffix!r}; expected .vtu; rename it")
    return target


def write_fields(
    path: Path,
    nodes: FloatArray,
    shapes: Sequence[IntArray],
    points: Mapping[str, FloatArray],
    cells: Mapping[str, FloatArray],
) -> None:
    """Write nodes (n_nodes, 3), the corners of each shape's elements, and fields on both, whole or not at all.

    Raises
    ------
    InputError
        If the file cannot be written.
    """
    sizes = np.concatenate([np.full(len(own), own.shape[1]) for own in shapes])
    lines = [
        '<?xml version="1.0"?>',
        '<VTKFile type="UnstructuredGrid" version="0.1" byte_order="LittleEndian"><UnstructuredGrid>',
        f'<Piece NumberOfPoints="{len(nodes)}" NumberOfCells="{len(sizes)}">',
        "<Points>",
        _array("points", nodes, "Float64"),
        "</Points><Cells>",
        _array("connectivity", np.concatenate([own.ravel() for own in shapes]), "Int64"),
        _array("offsets", np.cumsum(sizes), "Int64"),
        _array("types", np.array([SHAPES[size] for size in sizes.tolist()]), "UInt8"),
        "</Cells><PointData>",
        *(_array(name, values, "Float64") for name, values in points.items()),
        "</PointData><CellData>",
        *(_array(name, values, "Float64") for name, values in cells.items()),
        "</CellData></Piece></UnstructuredGrid></VTKFile>",
    ]
    with whole_file(path) as temporary:
        temporary.write_text("\n".join(lines) + "\n", encoding="ascii")


def _array(name: str, values: FloatArray | IntArray, kind: str) -> str:
    width = f' NumberOfComponents="{values.shape[1]}"' if values.ndim == 2 else ""
    words = " ".join(f"{v:.9g}" for v in values.ravel())
    return f'<DataArray type="{kind}" Name="{name}"{width} format="ascii">\n{words}\n</DataArray>'


def middle_strains(points: FloatArray, moved: FloatArray, axis: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return strain (n,) and its growth by height (n,) [1/m] along an axis at the middles of elements (n, k, 3)."""
    if points.shape[1] == quad4.N_NODES:
        many = quad4.strain_operators(points, [(0.0, 0.0)])
        membrane, curvature, axes = many.membrane[:, 0], many.curvature[:, 0], many.axes[:, 0]
    else:
        each = [tria3.strain_operator(corners) for corners in points]
        membrane, curvature, axes = (
            np.array([getattr(o, name) for o in each]) for name in ("membrane", "curvature", "axes")
        )
    along = axis @ axes
    c, s = along[:, :2].T / np.hypot(along[:, 0], along[:, 1])
    weights = np.stack([c * c, s * s, c * s], axis=1)
    strain, growth = (np.einsum("ec,eci,ei->e", weights, rows, moved) for rows in (membrane, curvature))
    return strain, growth
