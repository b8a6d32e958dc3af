"""Meshes from files of other programs: gmsh, Abaqus and CalculiX, Nastran, Salome, I-DEAS, VTK.

Taken from a file: nodes, shells of three and four nodes, lines of two, and what names them. Nothing else: no material,
load, support, mass or spring. A file that has something else that changes the structure gives a warning, and
`NamedMesh.left_out` says it.

| format | read by | element sets | node sets |
|---|---|---|---|
| gmsh .msh (2.2, 4.1) | meshio | physical groups, of lines and surfaces | physical groups of points |
| Abaqus, CalculiX .inp | `abaqus` | *ELSET, *ELEMENT with ELSET | *NSET, *NODE with NSET, ELSET of masses and springs |
| Nastran .bdf, .dat, .nas, .fem, .blk | `nastran` | "property:3", names in comments | "SPC:1", "CONM2:9", ... |
| I-DEAS .unv | `unv` | groups of elements | groups of nodes alone |
| Salome, Code_Aster .med | meshio | families' groups | the same of points |
| VTK .vtk | `vtk_legacy` | "name:value" of each whole-numbered cell array | the same of point arrays |
| VTK .vtu | meshio | the same | the same |

The nodes of every element set are a node set of the same name.
"""

import contextlib
import io
import re
import tempfile
import warnings
from collections.abc import Mapping, Sequence
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from femlib.arrays import BoolArray, FloatArray, IntArray
from femlib.errors import InputError, LeftOutWarning, MeshError, needed_by
from femlib.files import limited_memory, read_bytes
from femlib.kept import ReadOnly
from femlib.structure.abaqus import read_deck
from femlib.structure.file_mesh import FileMesh, value_sets, wrong_kind
from femlib.structure.gmsh_groups import add_groups
from femlib.structure.named_mesh import NamedMesh
from femlib.structure.nastran import read_bulk
from femlib.structure.unv import read_universal
from femlib.structure.vtk_legacy import read_legacy

if TYPE_CHECKING:
    import meshio

READERS = {
    ".msh": "gmsh", ".inp": "abaqus", ".bdf": "nastran", ".nas": "nastran", ".fem": "nastran", ".dat": "nastran",
    ".blk": "nastran", ".bulk": "nastran", ".vtk": "vtk", ".vtu": "vtu",
    ".unv": "unv", ".med": "med",
}  # fmt: skip
"""Format by the ending of a file's name."""
UNITS = {"m": 1.0, "mm": 1e-3, "cm": 1e-2, "in": 0.0254, "ft": 0.3048}
"""Metres in a unit of length."""
DIMENSIONS = {"quad": 2, "triangle": 2, "line": 1, "vertex": 0}
WIDTHS = {"quad": 4, "triangle": 3, "line": 2}
QUADRATIC = {"quad8": "quad", "quad9": "quad", "triangle6": "triangle", "triangle7": "triangle", "line3": "line"}
ROOM, ROOM_PER_BYTE = 2**28, 100
"""Bytes that reading a file may take, and bytes more for each of its own: gmsh's reader makes a table as long as the
largest number of a node, which one wrong digit makes thousands of millions."""
UNREAD = {
    b'compressor="vtkLZ4DataCompressor"': "it is compressed by LZ4, expected zlib, LZMA or none",
    b'type="String"': "it has texts as data, which are not read; take them out of its field data",
    b"<Piece .*<Piece ": "it has several pieces, of which meshio reads one; merge them",
}
"""What meshio does not read of a .vtu file, and the reason that it does not give."""
OLD_GMSH = re.compile(rb"\s*(?:\$NOD\s|\$MeshFormat\s+(?!4\.1|2\.2)([0-9.]{1,4}) )")
"""Beginning of a file of another version of gmsh's format than meshio reads."""
OF_RESULTS = re.compile(rb"\$(NodeData|ElementData|ElementNodeData)\s.*?\$End\1\s*", re.DOTALL)
"""Results in a file of gmsh, no part of the mesh: meshio refuses those of some nodes or elements alone."""
OWN_SETS = ("gmsh:geometrical", "gmsh:bounding_entities", "gmsh:dim_tags", "cell_tags", "point_tags")
"""What meshio keeps of gmsh's geometry, and of MED's families; no set of the user's."""


def read(
    mesh: "str | Path | meshio.Mesh", *, unit: str = "m", corners_only: bool = False, drop_lone_nodes: bool = False
) -> NamedMesh:
    """Return the mesh of a file, or of meshio, with its sets by name.

    Parameters
    ----------
    mesh : str, Path or meshio.Mesh
        A file with an ending of the table above, or a mesh that meshio has read from another.
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
        If meshio reads the format and is not installed.

    Warns
    -----
    LeftOutWarning
        If the file has what changes the structure and is not in a mesh: masses, springs, rigid elements, offsets,
        supports, loads.

    Examples
    --------
    >>> import meshio
    >>> points, line = [[0, 0, 0], [0.5, 0, 0], [1, 0, 0]], ("line", [[0, 1], [1, 2]])
    >>> sets = {"cell_sets": {"arm": [[0, 1]]}, "point_sets": {"foot": [0], "tip": [2]}}
    >>> mesh = read(meshio.Mesh(points, [line], **sets))
    >>> mesh.nodes[mesh.node_sets["tip"]].tolist()
    [[1.0, 0.0, 0.0]]
    """
    if unit not in UNITS:
        raise InputError(f"unit is {unit!r}; expected one of {list(UNITS)}; correct it")
    name = str(mesh) if isinstance(mesh, str | Path) else "the mesh"
    file = _read_file(Path(mesh)) if isinstance(mesh, str | Path) else _of_meshio(mesh)
    _check_unit(file, name, unit)
    blocks = [_block(*block, name, corners_only) for block in file.blocks]
    found = _ordered(file, _points(file.points, name, UNITS[unit]), blocks)
    if not found.n_elements:
        every = f", but {_listed(file.left_out)}" if file.left_out else ""
        raise MeshError(
            f"{name} has no shell and no line{every}; expected at least one; write the elements, not the geometry"
        )
    if file.left_out:
        told = f"{name}: left out of the mesh: {_listed(file.left_out)}; give to Structure what of it counts"
        warnings.warn(told, LeftOutWarning, stacklevel=2)
    return _without_lone_nodes(found) if drop_lone_nodes or corners_only else _checked_nodes(found, name)


def _check_unit(file: FileMesh, name: str, unit: str) -> None:
    """Refuse another unit than a file says, in four digits or more; metres are what Salome says of every mesh."""
    near = [own for own, size in UNITS.items() if abs(size / file.metres - 1.0) < 1e-4]
    if file.metres != 1.0 and unit not in near:
        cure = f"expected unit={near[0]!r}; give it" if near else f"expected one of {list(UNITS)}; save it in one"
        raise InputError(f"{name} says that its lengths are in {file.metres:.6g} m, but unit is {unit!r}; {cure}")


def _listed(left_out: Mapping[str, int]) -> str:
    return ", ".join(f"{n} {what}" for what, n in left_out.items())


def _read_file(path: Path) -> FileMesh:
    """Return what a file holds, by the reader of its format."""
    if path.suffix.lower() not in READERS:
        raise InputError(
            f"{path} ends in {path.suffix!r}; expected one of {sorted(READERS)}; rename it, or give meshio.read(path)"
        )
    kind = READERS[path.suffix.lower()]
    if kind in ("gmsh", "vtu", "med"):
        with needed_by("a mesh from a file"):
            reader = import_module(f"meshio.{kind}")
            if kind == "med":
                import_module("h5py")
        return _read_by_meshio(path, kind, reader)
    content = read_bytes(path, "a mesh file")
    try:
        with limited_memory(ROOM + ROOM_PER_BYTE * len(content)):
            if kind == "vtk":
                return read_legacy(content, path)
            return {"abaqus": read_deck, "nastran": read_bulk, "unv": read_universal}[kind](path)
    except MemoryError as error:
        raise _unreadable(path, kind, "it asks for more memory than a file of its size") from error


def _read_by_meshio(path: Path, kind: str, reader: Any) -> FileMesh:
    """Return what meshio's own reader of the format finds: `meshio.read` ends the program where a file is bad."""
    content = read_bytes(path, "a mesh file")
    for mark, reason in UNREAD.items():
        if kind == "vtu" and re.search(mark, content.partition(b"<AppendedData")[0], re.DOTALL):
            raise _unreadable(path, kind, reason)
    said = io.StringIO()
    try:
        with contextlib.redirect_stderr(said), limited_memory(ROOM + ROOM_PER_BYTE * len(content)):
            mesh = _without_results(path, content, reader) if kind == "gmsh" else reader.read(str(path))
            if kind == "gmsh":
                add_groups(mesh, content)
    except Exception as error:  # a reader fails in any way at what is not its format
        old = OLD_GMSH.match(content) if kind == "gmsh" else None
        if old:
            raise InputError(
                f"{path} is MSH {old[1].decode() if old[1] else '1'}; expected MSH 4.1 or 2.2; save it again "
                "(gmsh's option Mesh.MshFileVersion, or: gmsh old.msh -save -format msh41 -o new.msh)"
            ) from error
        raise _unreadable(path, kind, f"{type(error).__name__}: {error}".rstrip(": ")) from error
    if said.getvalue():  # a block that is not closed, an entry that is skipped: what is read is not the whole file
        raise _unreadable(path, kind, said.getvalue())
    return _of_meshio(mesh)


def _without_results(path: Path, content: bytes, reader: Any) -> Any:
    """Return meshio's mesh of a file of gmsh; one with results is read from a copy without them."""
    if not OF_RESULTS.search(content):
        return reader.read(str(path))
    with tempfile.TemporaryDirectory() as folder:
        copy = Path(folder, path.name)
        copy.write_bytes(OF_RESULTS.sub(b"", content))
        return reader.read(str(copy))


def _of_meshio(source: object) -> FileMesh:
    """Return a mesh of meshio as a file's, an element that gmsh wrote once for each of its groups as one."""
    with needed_by("a mesh from a file"):
        meshio = import_module("meshio")
    if not isinstance(source, meshio.Mesh):
        raise InputError(f"mesh is a {type(source).__name__}; expected a path or a mesh of meshio; give one")
    blocks = [(str(cell.type), np.asarray(cell.data, dtype=np.int64)) for cell in source.cells]
    told: dict[str, str] = {}
    found = FileMesh(np.asarray(source.points, dtype=np.float64), blocks, *_sets(source, blocks, told), {}, told)
    return _once(found) if "gmsh:physical" in source.cell_data else found


def _once(file: FileMesh) -> FileMesh:
    """Return the mesh with each element once, in all sets of its copies: MSH 2.2 writes one for each group."""
    blocks, first, starts = [], [], np.cumsum([0, *(len(own) for _, own in file.blocks)])
    for kind in dict.fromkeys(kind for kind, _ in file.blocks):
        own = [k for k, (its, _) in enumerate(file.blocks) if its == kind]
        corners = np.concatenate([file.blocks[k][1] for k in own])
        position = np.concatenate([np.arange(starts[k], starts[k + 1]) for k in own])
        _, at, copy = np.unique(np.sort(corners, axis=1), axis=0, return_index=True, return_inverse=True)
        order = np.argsort(at)
        blocks.append((kind, corners[at[order]]))
        first.append((position, np.argsort(order)[copy.ravel()], len(at)))
    sets = {}
    for name, mask in file.element_sets.items():
        counts = [np.bincount(copy, weights=mask[position], minlength=n) for position, copy, n in first]
        sets[name] = np.concatenate(counts) > 0.0
    return FileMesh(file.points, blocks, sets, file.node_sets, file.left_out, file.without_set)


def _unreadable(path: Path, kind: str, reason: str) -> InputError:
    options = ", of gmsh without Mesh.SaveAll, Mesh.SaveParametric and partitions," if kind == "gmsh" else ""
    return InputError(
        f"{path} could not be read as {kind} ({' '.join(reason.split())[:120]}); "
        f"expected a whole mesh file of that format; write it again{options} or correct its ending"
    )


def _points(places: FloatArray, name: str, scale: float) -> FloatArray:
    points = scale * places
    if not points.size:
        raise MeshError(f"{name} has no node; expected a mesh; check that it is a file of that format")
    if points.ndim != 2 or points.shape[1] not in (2, 3):
        raise InputError(f"{name} has nodes of shape {points.shape}; expected ('n', 3); write coordinates in space")
    return np.column_stack([points, np.zeros(len(points))]) if points.shape[1] == 2 else points


def _block(kind: str, corners: IntArray, name: str, corners_only: bool) -> tuple[str, IntArray]:
    """Return the kind and corners of a block of elements."""
    if kind in QUADRATIC:
        if not corners_only:
            raise MeshError(
                f"{name} has {len(corners)} quadratic elements ({kind}); expected shells of 3 and 4 nodes and lines of "
                "2; mesh with linear elements, or read(..., corners_only=True) to leave out the nodes between corners"
            )
        return QUADRATIC[kind], corners[:, : WIDTHS[QUADRATIC[kind]]]
    if kind not in (*WIDTHS, "vertex"):
        raise wrong_kind(name, len(corners), kind)
    return kind, corners


Sets = tuple[dict[str, BoolArray], dict[str, IntArray]]


def _sets(source: Any, blocks: Sequence[tuple[str, IntArray]], told: dict[str, str]) -> Sets:
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
            dimensions = np.repeat([DIMENSIONS.get(QUADRATIC.get(kind, kind), 3) for kind, _ in blocks], sizes)
            elements |= _values(name, values, dimensions, source.field_data, told)
    nodes = {name: np.asarray(own, dtype=np.int64) for name, own in source.point_sets.items()}
    for name, values in source.point_data.items():
        if name not in OWN_SETS:
            found = value_sets(name, np.asarray(values), told)
            nodes |= {key: np.flatnonzero(mask) for key, mask in found.items()}
    if getattr(source, "cell_tags", {}):
        elements |= _families(source.cell_tags, np.concatenate(source.cell_data["cell_tags"]))
    if getattr(source, "point_tags", {}):
        found = _families(source.point_tags, source.point_data["point_tags"])
        nodes |= {name: np.flatnonzero(mask) for name, mask in found.items()}
    return elements, nodes


def _families(groups: Mapping[int, Sequence[str]], tags: IntArray) -> dict[str, BoolArray]:
    """Return the members of MED's groups as truth values (n,), by the families (n,): a group is one or several."""
    found = dict[str, BoolArray]()
    for tag, names in groups.items():
        found |= {name: found.get(name, False) | (tags == tag) for name in names}
    return found


def _values(
    name: str, values: Any, dimensions: IntArray, names: Mapping[str, Any], told: dict[str, str]
) -> dict[str, BoolArray]:
    """Return a set for each value of a cell array of whole numbers, by gmsh's names where it has some."""
    if name != "gmsh:physical":
        return value_sets({"nastran:ref": "property"}.get(name, name), values, told)
    groups = {own: np.asarray(pair).tolist() for own, pair in names.items()}
    found = {own: (values == tag) & (dimensions == dimension) for own, (tag, dimension) in groups.items()}
    named = {f"physical:{tag}" for tag, _ in groups.values()}
    return found | {key: mask for key, mask in value_sets("physical", values, told).items() if key not in named}


def _ordered(file: FileMesh, points: FloatArray, blocks: Sequence[tuple[str, IntArray]]) -> NamedMesh:
    """Return the mesh with its elements in the order quadrilaterals, triangles, lines; points of gmsh become nodes."""
    sizes = [len(corners) for _, corners in blocks]
    kind = np.repeat(np.array([own for own, _ in blocks], dtype="U8"), sizes)
    rows = np.full((len(kind), 4), -1, dtype=np.int64)
    for start, (_, own) in zip(np.cumsum([0, *sizes]), blocks, strict=False):
        rows[start : start + len(own), : own.shape[1]] = own
    # A quadrilateral two of whose neighbouring corners are one node is how some programs write a triangle.
    same = rows == np.roll(rows, -1, axis=1)
    folded = (kind == "quad") & (same.sum(axis=1) == 1)
    rows[folded, :3] = rows[folded][~same[folded]].reshape(-1, 3)
    kind[folded] = "triangle"
    order = np.concatenate([np.flatnonzero(kind == own) for own in WIDTHS])
    vertices = rows[kind == "vertex", 0]
    of_nodes = dict(file.node_sets)
    for name, mask in file.element_sets.items():
        at = vertices[mask[kind == "vertex"]]
        if at.size and not mask[order].any():
            of_nodes[name] = at
    of_elements = {
        name: mask[order] for name, mask in file.element_sets.items() if name not in of_nodes or mask[order].any()
    }
    quads, trias, lines = (rows[kind == own, :width] for own, width in WIDTHS.items())
    left_out = ReadOnly({name: str(n) for name, n in file.left_out.items()} | file.without_set)
    return NamedMesh(points, quads, trias, lines, of_elements, of_nodes, left_out)


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
    return NamedMesh(mesh.nodes[kept], *corners, mesh.element_sets, nodes, mesh.left_out)
