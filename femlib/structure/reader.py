"""Meshes from files of other programs: gmsh, Abaqus and CalculiX, Nastran, VTK, through meshio.

Taken from a file: nodes, shells of three and four nodes, lines of two, and what names them. Nothing else: no material,
load, support, mass or spring of the file is read.

| format | element sets | node sets |
|---|---|---|
| gmsh .msh (2.2, 4.1) | physical groups, of lines and surfaces | physical groups of points |
| Abaqus, CalculiX .inp | *ELSET, *ELEMENT with ELSET | *NSET, *NODE with NSET |
| Nastran .bdf, .nas, .fem | "property:3" for property 3 | none |
| VTK .vtk, .vtu | "name:value" of each whole-numbered cell array | the same of point arrays |

The nodes of every element set are a node set of the same name.
"""

import contextlib
import io
from collections.abc import Mapping, Sequence
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from femlib.arrays import BoolArray, FloatArray, IntArray
from femlib.errors import InputError, MeshError, needed_by
from femlib.files import limited_memory, read_bytes
from femlib.structure.abaqus_sets import deck_sets, masks
from femlib.structure.named_mesh import NamedMesh

if TYPE_CHECKING:
    import meshio

READERS = {
    ".msh": "gmsh",
    ".inp": "abaqus",
    ".bdf": "nastran",
    ".nas": "nastran",
    ".fem": "nastran",
    ".vtk": "vtk",
    ".vtu": "vtu",
}
"""meshio's reader by the ending of a file's name."""
UNITS = {"m": 1.0, "mm": 1e-3, "cm": 1e-2, "in": 0.0254, "ft": 0.3048}
"""Metres in a unit of length."""
WIDTHS = {"quad": 4, "triangle": 3, "line": 2}
QUADRATIC = {"quad8": "quad", "quad9": "quad", "triangle6": "triangle", "triangle7": "triangle", "line3": "line"}
ROOM, ROOM_PER_BYTE = 2**28, 100
"""Bytes that reading a file may take, and bytes more for each of its own: gmsh's reader makes a table as long as the
largest number of a node, which one wrong digit makes thousands of millions."""
MOST_VALUES = 1000
"""An array of cells or points with more values than that numbers them and names no set."""
OWN_SETS = ("gmsh:geometrical", "gmsh:bounding_entities", "gmsh:dim_tags")
"""What meshio keeps of gmsh's geometry; no set of the user's."""


def read(
    mesh: "str | Path | meshio.Mesh", *, unit: str = "m", corners_only: bool = False, drop_lone_nodes: bool = False
) -> NamedMesh:
    """Return the mesh of a file, or of meshio, with its sets by name.

    Parameters
    ----------
    mesh : str, Path or meshio.Mesh
        A file that ends in .msh, .inp, .bdf, .nas, .fem, .vtk or .vtu, or a mesh that meshio has read from another.
    unit : str
        Unit of its coordinates: m, mm, cm, in or ft.
    corners_only : bool
        Take quadratic elements as linear ones, by their corners.
    drop_lone_nodes : bool
        Leave out nodes that belong to no element, as the middles of arcs.

    Raises
    ------
    InputError
        If the file cannot be read, has volume or quadratic elements, or no element at all.
    MissingExtraError
        If meshio is not installed.
    """
    with needed_by("a mesh from a file"):
        meshio = import_module("meshio")
    if unit not in UNITS:
        raise InputError(f"unit is {unit!r}; expected one of {list(UNITS)}; correct it")
    name = str(mesh) if isinstance(mesh, str | Path) else "the mesh"
    source: Any = _read_file(Path(mesh)) if isinstance(mesh, str | Path) else mesh
    if not isinstance(source, meshio.Mesh):
        raise InputError(f"mesh is a {type(mesh).__name__}; expected a path or a mesh of meshio; give one")
    blocks = [_block(cell, name, corners_only) for cell in source.cells]
    is_deck = isinstance(mesh, str | Path) and Path(mesh).suffix.lower() == ".inp"
    sets = _deck_masks(source, Path(name)) if is_deck else _sets(source, blocks)
    found = _ordered(_points(source, name, UNITS[unit]), blocks, *sets)
    if not found.n_elements:
        raise MeshError(f"{name} has no shell and no line; expected at least one; write the elements, not the geometry")
    return _without_lone_nodes(found) if drop_lone_nodes or corners_only else _checked_nodes(found, name)


def _read_file(path: Path) -> Any:
    """Return meshio's mesh of a file.

    By the format's own reader: `meshio.read` ends the program where a file is bad.
    """
    content = read_bytes(path, "a mesh file")
    if path.suffix.lower() not in READERS:
        raise InputError(
            f"{path} ends in {path.suffix!r}; expected one of {sorted(READERS)}; rename it, or give meshio.read(path)"
        )
    kind = READERS[path.suffix.lower()]
    if kind == "nastran" and not _has_cards(content):
        raise _unreadable(path, kind, "no card after BEGIN BULK")
    reader = import_module(f"meshio.{kind}")
    said = io.StringIO()
    try:
        with contextlib.redirect_stderr(said), limited_memory(ROOM + ROOM_PER_BYTE * len(content)):
            mesh = reader.read(str(path))
    except Exception as error:  # a reader fails in any way at what is not its format
        raise _unreadable(path, kind, f"{type(error).__name__}: {error}") from error
    if said.getvalue():  # a block that is not closed, an entry that is skipped: what is read is not the whole file
        raise _unreadable(path, kind, said.getvalue())
    return mesh


def _has_cards(content: bytes) -> bool:
    """Whether a bulk data file has a card: meshio's reader looks for the first one without end."""
    after = content.partition(b"BEGIN BULK")[2].splitlines()[1:]
    return any(len(line) >= 4 and not line.startswith((b"$", b"//", b"#")) for line in after)


def _unreadable(path: Path, kind: str, reason: str) -> InputError:
    return InputError(
        f"{path} could not be read as {kind} ({' '.join(reason.split())[:120]}); "
        "expected a whole mesh file of that format; write it again or correct its ending"
    )


def _points(source: Any, name: str, scale: float) -> FloatArray:
    references = source.point_data.get("nastran:ref")
    if references is not None and np.any(references):
        raise InputError(f"{name} has nodes in a coordinate system of their own; expected global ones; write them so")
    points = scale * np.asarray(source.points, dtype=np.float64)
    if not points.size:
        raise MeshError(f"{name} has no node; expected a mesh; check that it is a file of that format")
    if points.ndim != 2 or points.shape[1] not in (2, 3):
        raise InputError(f"{name} has nodes of shape {points.shape}; expected ('n', 3); write coordinates in space")
    return np.column_stack([points, np.zeros(len(points))]) if points.shape[1] == 2 else points


def _block(cell: Any, name: str, corners_only: bool) -> tuple[str, IntArray]:
    """Return the kind and corners of a block of elements."""
    kind, corners = str(cell.type), np.asarray(cell.data, dtype=np.int64)
    if kind in QUADRATIC:
        if not corners_only:
            raise MeshError(
                f"{name} has {len(corners)} quadratic elements ({kind}); expected shells of 3 and 4 nodes and lines of "
                "2; mesh with linear elements, or read(..., corners_only=True) to leave out the nodes between corners"
            )
        return QUADRATIC[kind], corners[:, : WIDTHS[QUADRATIC[kind]]]
    if kind not in (*WIDTHS, "vertex"):
        raise MeshError(
            f"{name} has {len(corners)} elements of kind {kind}; expected shells and lines, no volumes; mesh the "
            "middle surfaces"
        )
    return kind, corners


Sets = tuple[dict[str, BoolArray], dict[str, IntArray]]


def _deck_masks(source: Any, path: Path) -> Sets:
    """Return the sets of a deck: of all elements in the order of their blocks, and of nodes."""
    text = read_bytes(path, "a mesh file").decode("utf-8", errors="replace")
    try:
        found = deck_sets(text, [cell.data.shape[1] for cell in source.cells], path)
    except (ValueError, IndexError, KeyError, StopIteration, TypeError) as error:
        if isinstance(error, InputError):
            raise
        raise _unreadable(path, "abaqus", f"its sets: {type(error).__name__}: {error}") from error
    elements = masks(found.elements, sum(len(cell.data) for cell in source.cells))
    return elements, {name: np.array(own, dtype=np.int64) for name, own in found.nodes.items()}


def _sets(source: Any, blocks: Sequence[tuple[str, IntArray]]) -> Sets:
    """Return the sets that meshio keeps: of all elements in the order of their blocks, and of nodes."""
    sizes = [len(corners) for _, corners in blocks]
    first = np.cumsum([0, *sizes])
    elements: dict[str, BoolArray] = {}
    for name, parts in source.cell_sets.items():
        if name not in OWN_SETS:
            mask = elements.setdefault(name, np.zeros(first[-1], dtype=bool))
            for start, part in zip(first, parts, strict=False):
                if part is not None:
                    mask[start + np.asarray(part, dtype=np.int64)] = True
    for name, parts in source.cell_data.items():
        if name not in OWN_SETS and not (name == "gmsh:physical" and source.cell_sets):
            values = np.concatenate([np.asarray(part) for part in parts])
            dimensions = np.repeat([{"quad": 2, "triangle": 2, "line": 1}.get(kind, 0) for kind, _ in blocks], sizes)
            elements |= _values(name, values, dimensions, source.field_data)
    nodes = {name: np.asarray(own, dtype=np.int64) for name, own in source.point_sets.items()}
    for name, values in source.point_data.items():
        if name not in (*OWN_SETS, "nastran:ref"):
            found = _values(name, np.asarray(values), None, {})
            nodes |= {key: np.flatnonzero(mask) for key, mask in found.items()}
    return elements, nodes


def _values(name: str, values: Any, dimensions: IntArray | None, names: Mapping[str, Any]) -> dict[str, BoolArray]:
    """Return a set for each value of an array of whole numbers, by gmsh's names where it has some."""
    if values.ndim != 1 or not np.issubdtype(values.dtype, np.integer):
        return {}
    kinds = np.unique(values)
    if len(kinds) > MOST_VALUES:
        return {}
    found = {}
    if name == "gmsh:physical":
        for own, (tag, dimension) in ((key, np.asarray(pair).tolist()) for key, pair in names.items()):
            found[own] = (values == tag) & (dimensions == dimension)
    named = {int(np.asarray(pair)[0]) for pair in names.values()} if name == "gmsh:physical" else set()
    label = {"nastran:ref": "property", "gmsh:physical": "physical"}.get(name, name)
    return found | {f"{label}:{value}": values == value for value in kinds.tolist() if value not in named}


def _ordered(
    points: FloatArray,
    blocks: Sequence[tuple[str, IntArray]],
    elements: Mapping[str, BoolArray],
    nodes: Mapping[str, IntArray],
) -> NamedMesh:
    """Return the mesh with its elements in the order quadrilaterals, triangles, lines; points of gmsh become nodes."""
    kind = np.repeat([own for own, _ in blocks], [len(corners) for _, corners in blocks])
    order = np.concatenate([np.flatnonzero(kind == own) for own in WIDTHS] or [np.zeros(0, dtype=np.int64)])
    corners = {
        own: np.concatenate([np.zeros((0, width), dtype=np.int64), *(c for k, c in blocks if k == own)])
        for own, width in WIDTHS.items()
    }
    vertices = np.concatenate([np.zeros(0, dtype=np.int64), *(c.ravel() for k, c in blocks if k == "vertex")])
    of_nodes = dict(nodes)
    for name, mask in elements.items():
        at = vertices[mask[kind == "vertex"]]
        if at.size and not mask[order].any():
            of_nodes[name] = at
    of_elements = {name: mask[order] for name, mask in elements.items() if name not in of_nodes or mask[order].any()}
    return NamedMesh(points, corners["quad"], corners["triangle"], corners["line"], of_elements, of_nodes)


def _lone(mesh: NamedMesh) -> IntArray:
    every = np.ones(mesh.n_elements, dtype=bool)
    return np.setdiff1d(np.arange(len(mesh.nodes)), mesh.nodes_at(every))


def _checked_nodes(mesh: NamedMesh, name: str) -> NamedMesh:
    lone = _lone(mesh)
    if lone.size:
        raise MeshError(
            f"{name}: node {lone[0]} at {mesh.nodes[lone[0]].tolist()} belongs to no element ({lone.size} such nodes); "
            "expected nodes of elements; delete them or read(..., drop_lone_nodes=True)"
        )
    return mesh


def _without_lone_nodes(mesh: NamedMesh) -> NamedMesh:
    kept = np.setdiff1d(np.arange(len(mesh.nodes)), _lone(mesh))
    number = np.full(len(mesh.nodes), -1)
    number[kept] = np.arange(len(kept))
    nodes = {name: number[own][number[own] >= 0] for name, own in mesh.node_sets.items()}
    corners = (number[mesh.quads], number[mesh.trias], number[mesh.lines])
    return NamedMesh(mesh.nodes[kept], *corners, mesh.element_sets, nodes)
