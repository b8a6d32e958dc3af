"""The door `femlib.read`: meshes and decks of gmsh, pyNastran, meshio, VTK, Abaqus, CalculiX and femlib itself."""

import importlib
import warnings
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import femlib
from femlib.errors import LeftOutWarning
from tests.doors.row import Refused, Row

DOOR = "femlib.read"


def area(mesh: Any) -> float:
    """Return the area of all shells."""
    corners = [mesh.nodes[own] for own in (mesh.quads, mesh.trias) if len(own)]
    return sum(
        float(np.linalg.norm(np.cross(p[:, 2] - p[:, 0], p[:, -1] - p[:, 1]), axis=1).sum()) / 2 for p in corners
    )


def read(path: Path) -> dict[str, Any]:
    """Return what a file holds: counts, area, sizes of sets that it names, and what it says is left out."""
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always", LeftOutWarning)
        mesh = femlib.read(path, corners_only=True)
    every = {name: int(own.sum()) for name, own in mesh.element_sets.items()}
    every |= {f"nodes {name}": len(own) for name, own in mesh.node_sets.items()}
    counts = (len(mesh.nodes), len(mesh.quads), len(mesh.trias), len(mesh.lines))
    words = " ".join(str(own.message).partition("mesh: ")[2].partition("; give")[0] for own in told)
    return {"counts": counts, "area": round(area(mesh), 6), "sets": every, "told": words}


def answer(counts: Sequence[int], size: float, sets: dict[str, int], told: str = "") -> dict[str, Any]:
    return {"counts": tuple(counts), "area": size, "sets": sets, "told": told}


def written(name: str, text: str, **others: str) -> Callable[[Path], Path]:
    """Return what writes a text, and other files beside it."""

    def make(folder: Path) -> Path:
        for own, content in {
            name: text,
            **{k.replace("__", "/").replace("_", "."): v for k, v in others.items()},
        }.items():
            (folder / own).parent.mkdir(exist_ok=True)
            (folder / own).write_text(content, encoding="cp1252")
        return folder / name

    return make


GRIDS = "GRID,1,,0.,0.,0.\nGRID,2,,1.,0.,0.\nGRID,3,,1.,1.,0.\nGRID,4,,0.,1.,0.\n"
QUAD = "CQUAD4,1,5,1,2,3,4"
ONE = {"property:5": 1}
PYNASTRAN_DOUBLE = """$pyNastran: version=msc
$pyNastran: punch=True
GRID*                  1                0.0000000000D+000.0000000000D+00
*       0.0000000000D+00
GRID*                  2                1.0000000000D+000.0000000000D+00
*       0.0000000000D+00
GRID*                  3                2.0000000000D+000.0000000000D+00
*       0.0000000000D+00
GRID*                  4                0.0000000000D+001.0000000000D+00
*       0.0000000000D+00
GRID*                  5                1.0000000000D+001.0000000000D+00
*       0.0000000000D+00
GRID*                  6                2.0000000000D+001.0000000000D+00
*       0.0000000000D+00
CQUAD4*                1               5               1               2
*                      5               4             30.
CQUAD4*                2               6               2               3
*                      6               5               0            .002
PCOMP*                 6
*                                                                    SYM
*                      2            .001              0.
CONM2*                 9               3                             1.5
*
RBE2          10       1  123456       4
FORCE*                 3               6                1.0000000000D+01
*       0.0000000000D+000.0000000000D+001.0000000000D+00
SPC1           1  123456       1       4
"""
SYSTEMS = """CORD2C         2       0      0.      0.      0.      0.      0.      1.
              1.      0.      0.
CORD1R         4       1       2       3
GRDSET                 2
GRID           1       0      1.      0.      0.
GRID           2       0      2.      0.      0.
GRID           3              2.     90.      0.
GRID           4       4      0.      1.      0.
CTRIA3         1       5       1       2       3
CTRIA3         2       5       1       3       4
CBAR           3       7       1       3      0.      0.      1.
"""
"""Nodes at (1, 0, 0), (2, 0, 0), (0, 2, 0); the fourth one along y of the system of the three, z: (1, 0, 1)."""
NASTRAN = {
    "plain": (f"BEGIN BULK\n{GRIDS}{QUAD}\nENDDATA\n", ""),
    "without ENDDATA": (f"SOL 101\nCEND\nBEGIN BULK\n{GRIDS}{QUAD}\n", ""),
    "D exponents": (f"{GRIDS.replace('1.,0.,0.', '1.D0,0.,0.')}{QUAD}\n", ""),
    "exponents without a letter": (f"{GRIDS.replace('1.,0.,0.', '.1+1,0.,0.')}{QUAD}\n", ""),
    "THETA": (f"{GRIDS}{QUAD},30.\n", "1 THETA or MCID (directions of the material)"),
    "THETA of zero": (f"{GRIDS}{QUAD},0.0\n", ""),
    "MCID": (f"{GRIDS}{QUAD},0\n", "1 THETA or MCID (directions of the material)"),
    "TOP of OptiStruct": (f"{GRIDS}{QUAD},,TOP\n", "1 ZOFFS (shells beside their nodes)"),
    "ZOFFS of OptiStruct's property": (f"{GRIDS}{QUAD}\nPSHELL,5,1,.1\n,,,,,-.05\n",
                                       "1 ZOFFS of PSHELL (shells beside their nodes)"),
    "a symmetric stack of OptiStruct": (f"{GRIDS}{QUAD}\nPCOMP,5,-.002,,,,,,SYSMEAR\n,2,.001,0.,,2,,90.\n", ""),
    "thickness at a corner": (f"{GRIDS}{QUAD},,,\n,,,.002\n", "1 T1 to T4 (thickness at corners)"),
    "comment behind fields, lower case": (f"{GRIDS.lower()}{QUAD.lower()} $ one\n", ""),
    "tabs": (f"{GRIDS.replace(',', chr(9))}{QUAD.replace(',', chr(9))}\n", ""),
    "a spring and what is unknown": (f"{GRIDS}{QUAD}\nCELAS2,9,1.,1,3\nXYZ,1\n",
                                     "1 CELAS2 (springs), 1 XYZ (not read)"),
    "a stack above its nodes": (f"{GRIDS}{QUAD}\nPCOMP,5,0.0\n,2,.001,0.,,2,.001,90.\n",
                                "1 Z0 of PCOMP (plies beside their nodes)"),
    "a ply that has an angle alone": (f"{GRIDS}{QUAD}\nPCOMP,5,-.002\n,2,.001,0.,,,,90.\n,,,45.,,,,0.\n", ""),
    "a system of materials": (f"CORD3G,5,E313,E,1,2,3,0\n{GRIDS}{QUAD}\n", ""),
    "plates of MYSTRAN": (f"{GRIDS}{QUAD.replace('4,', '4K,', 1)}\n", ""),
    "a node held by its GRID": (f"{GRIDS}GRID,5,,0.,2.,0.,,123\n{QUAD}\n", "1 PS of GRID (supports)"),
}  # fmt: skip
NODES = "*NODE\n1,0,0,0\n2,1,0,0\n3,2,0,0\n4,0,1,0\n5,1,1,0\n6,2,1,0\n"
SHELLS = "*ELEMENT,TYPE=S4,ELSET=SKIN\n1,1,2,5,4\n2,2,3,6,5\n"
EIGHT = "*NODE\n1,0,0\n2,2,0\n3,2,2\n4,0,2\n5,1,0\n6,2,1\n7,1,2\n8,0,1\n9,1,1\n"
NINE = (
    "".join(
        f"GRID,{k},,{x}.,{y}.,0.\n"
        for k, (x, y) in enumerate([(0, 0), (2, 0), (2, 2), (0, 2), (1, 0), (2, 1), (1, 2), (0, 1), (1, 1)], start=1)
    )
    + "CQUAD9,1,1,1,2,3,4,5,6,+E1\n+E1,7,8,9\n"
)
SIX = "*NODE\n1,0,0\n2,2,0\n3,0,2\n4,1,0\n5,1,1\n6,0,1\n"
INSTANCES = """*Part, name=Plate
*Node
1, 0., 0., 0.
2, 1., 0., 0.
3, 1., 1., 0.
4, 0., 1., 0.
*Element, type=S4R
1, 1, 2, 3, 4
*Elset, elset=Set-1
 1,
*End Part
*Assembly, name=Assembly
*Instance, name=Plate-1, part=Plate
*End Instance
*Instance, name=Plate-2, part=Plate
 2., 0., 0.
 2., 0., 0., 2., 0., 1., 90.
*End Instance
*Nset, nset=root, instance=Plate-1
 1, 4
*Nset, nset=root, instance=Plate-2
 2
*Elset, elset=right
 Plate-2.Set-1
*End Assembly
"""
ABAQUS: dict[str, tuple[str, dict[str, int], str]] = {
    "a mass": ("*ELEMENT,TYPE=MASS,ELSET=M\n9,3\n*MASS,ELSET=M\n1.\n", {"nodes M": 1}, "1 MASS (masses)"),
    "a spring to the ground": ("*ELEMENT,TYPE=SPRING1,ELSET=S\n9,3\n", {"nodes S": 1}, "1 SPRING1 (springs)"),
    "a spring between nodes": ("*ELEMENT,TYPE=SPRINGA,ELSET=S\n9,3,6\n", {"nodes S": 2}, "1 SPRINGA (springs)"),
    "GENERATE without a step": ("*ELSET,ELSET=B,GENERATE\n1,2\n", {"B": 2}, ""),
    "a set of a set, in capitals or not": ("*ELSET,ELSET=All\nskin\n", {"All": 2}, ""),
    "one set in two cases": ("*NSET,NSET=A\n1\n*NSET,NSET=a\n2\n", {"nodes A": 2}, ""),
    "names in quotes, and of Windows": ('*ELSET,ELSET="top, H\u00fclle"\n1\n', {"top, H\u00fclle": 1}, ""),
    "the nodes of a set of elements": ("*NSET,NSET=N,ELSET=skin\n", {"nodes N": 6}, ""),
    "a keyword line that goes on": ("*ELSET, ELSET=B,\nGENERATE\n1,2\n", {"B": 2}, ""),
    "nodes between nodes, elements again": (
        "*NODE\n11,0,2\n13,2,2\n*NGEN\n11,13\n*ELEMENT,TYPE=S4R\n7,4,5,12,11\n"
        "*ELGEN,ELSET=UP\n7,2,1,1\n", {"UP": 2}, ""),
    "a node at two places, one twice at one": ("*NODE\n1,0\n9,5,5\n9,6,6\n", {},
                                                "1 *NODE (places of nodes that are given again)"),
    "an offset": ("*SHELL SECTION,ELSET=SKIN,MATERIAL=M,OFFSET=SPOS\n.002\n", {},
                  "1 OFFSET of *SHELL SECTION (elements beside their nodes)"),
    "constraints, loads, supports": ("*RIGID BODY,NSET=X\n*CLOAD\n1,1,1.\n*BOUNDARY\n2,1,6\n*RELEASE\n1,S1\n", {},
                                     "1 *RIGID BODY (constraints), 1 *CLOAD (loads), 1 *BOUNDARY (supports), "
                                     "1 *RELEASE (released ends)"),
    "rigid shells": ("*ELEMENT,TYPE=R3D4,ELSET=R\n9,1,2,5,4\n", {"nodes R": 4}, "1 R3D4 (rigid elements)"),
    "a set before its elements, comments": ("** none\n*ELSET,ELSET=Q\nP\n*ELSET,ELSET=P\n2\n", {"Q": 1, "P": 1}, ""),
}  # fmt: skip
QUADRATIC = {"S8R": EIGHT, "S8R5": EIGHT, "CPS8": EIGHT, "S9R5": EIGHT, "S6": SIX, "STRI65": SIX, "CPS6": SIX}
LINEAR = {"S4R5": EIGHT, "S4RS": EIGHT, "CPS4R": EIGHT, "S3R": SIX, "STRI3": SIX, "CPS3": SIX}


def element(name: str) -> str:
    """Return a deck of one element: the nodes of `EIGHT` or `SIX`, as many as its type takes."""
    nodes = (QUADRATIC | LINEAR)[name]
    n = {"S9R5": 9}.get(name, (8 if nodes is EIGHT else 6) if name in QUADRATIC else (4 if nodes is EIGHT else 3))
    return f"{nodes}*ELEMENT, TYPE={name}, ELSET=SKIN\n1, {', '.join(str(k + 1) for k in range(n))}\n"


VERSIONS = {"a1.msh": 1.0, "a40.msh": 4.0, "a4.msh": 4.1, "all.msh": 4.1}


def gmsh_file(name: str, order: int = 1, is_long: bool = False) -> Callable[[Path], Path]:
    """Return what lets gmsh mesh two squares of triangles, all in `skin`, the second in `bay` too."""

    def make(folder: Path) -> Path:
        gmsh = pytest.importorskip("gmsh")
        gmsh.initialize(interruptible=False)
        wanted = {"General.Terminal": 0, "Mesh.MeshSizeMin": 9, "Mesh.MeshSizeMax": 9, "Mesh.ElementOrder": order}
        wanted |= {"Mesh.BdfFieldFormat": 2 if is_long else 1, "Mesh.MshFileVersion": VERSIONS.get(name, 2.2)}
        wanted |= {"Mesh.SaveAll": name == "all.msh"}
        for option, value in wanted.items():
            gmsh.option.setNumber(option, value)
        for x in (0, 1):
            gmsh.model.occ.addRectangle(x, 0, 0, 1, 1)
        gmsh.model.occ.fragment([(2, 1)], [(2, 2)])
        gmsh.model.occ.synchronize()
        gmsh.model.addPhysicalGroup(2, [1, 2], name="skin")
        gmsh.model.addPhysicalGroup(2, [2], name="bay")
        gmsh.model.mesh.generate(2)
        gmsh.write(str(folder / name))
        gmsh.finalize()
        return folder / name

    return make


def vtk_file(name: str, kind: str, is_binary: bool, version: int = 51) -> Callable[[Path], Path]:
    """Return what lets VTK write a square and a triangle with a cell array of a kind, named as its scalars."""

    def make(folder: Path) -> Path:
        legacy = pytest.importorskip("vtkmodules.vtkIOLegacy")
        xml, data = (importlib.import_module(f"vtkmodules.{own}") for own in ("vtkIOXML", "vtkCommonDataModel"))
        numbers, core = (
            importlib.import_module(f"vtkmodules.{own}") for own in ("util.numpy_support", "vtkCommonCore")
        )
        grid, points, ids = data.vtkUnstructuredGrid(), core.vtkPoints(), core.vtkIdList()
        for place in ((0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (2, 0, 0)):
            points.InsertNextPoint(place)
        grid.SetPoints(points)
        for number, corners in ((9, (0, 1, 2, 3)), (5, (1, 4, 2))):
            ids.Reset()
            for corner in corners:
                ids.InsertNextId(corner)
            grid.InsertNextCell(number, ids)
        region = numbers.numpy_to_vtk(np.array([1, 7], dtype=kind), deep=True)
        region.SetName("region")
        grid.GetCellData().SetScalars(region)
        writer = legacy.vtkUnstructuredGridWriter() if name.endswith("k") else xml.vtkXMLUnstructuredGridWriter()
        writer.SetInputData(grid)
        writer.SetFileName(str(folder / name))
        if name.endswith("k"):
            writer.SetFileVersion(version)
            (writer.SetFileTypeToBinary if is_binary else writer.SetFileTypeToASCII)()
        else:
            (writer.SetCompressorTypeToLZ4 if kind == "i4" else writer.SetCompressorTypeToZLib)()
            writer.SetEncodeAppendedData(is_binary)
        writer.Write()
        return folder / name

    return make


def meshio_file(name: str, kind: str) -> Callable[[Path], Path]:
    """Return what lets meshio write one element."""

    def make(folder: Path) -> Path:
        meshio = pytest.importorskip("meshio")
        corners = np.array([[0, 0, 0], [2, 0, 0], [2, 2, 0], [0, 2, 0]])[: 4 if kind.startswith("quad") else 3]
        both = np.concatenate([corners, (corners + np.roll(corners, -1, axis=0)) / 2])
        places = both if kind[-1].isdigit() else corners
        mesh = meshio.Mesh(places.astype(float), [(kind, np.arange(len(places))[None])])
        mesh.cell_sets["SKIN"] = [np.array([0])]
        meshio.write(folder / name, mesh)
        return folder / name

    return make


VTK_ANSWER = answer((5, 1, 1, 0), 1.5, {"region:1": 1, "region:7": 1})
ROUNDED = "last digits of nodes (gmsh rounds them; set its Mesh.BdfFieldFormat to 2)"
GROUPS = {"skin": 8, "bay": 4}
ROWS = [
    *(
        Row(DOOR, "Nastran's guide", case, written("a.bdf", text), read,
            answer((4, 1, 0, 0), 1.0, ONE | ({"nodes CELAS2:9": 1} if "spring" in case else {}), told))
        for case, (text, told) in NASTRAN.items()
    ),
    Row(DOOR, "pyNastran 1.4.1, kept", "long fields", written("a.nas", PYNASTRAN_DOUBLE), read,
        answer((6, 2, 0, 0), 2.0, {"property:5": 1, "property:6": 1, "nodes CONM2:9": 1, "nodes FORCE:3": 1,
                                   "nodes SPC:1": 2},
               "2 THETA or MCID (directions of the material), 1 ZOFFS (shells beside their nodes), 1 CONM2 (masses), "
               "1 RBE2 (rigid elements), 1 FORCE (loads), 1 SPC1 (supports)")),
    Row(DOOR, "pyNastran 1.4.1, kept", "coordinate systems", written("a.dat", SYSTEMS), read,
        answer((4, 0, 2, 1), 2.118034, {"property:5": 2, "property:7": 1})),
    Row(DOOR, "Nastran's guide", "an included file, names in comments",
        written("a.bdf", f"INCLUDE 'sub\\b.bdf'\n$HMNAME PROP  5\"skin\" 4\n{QUAD}\n",
                sub__b_bdf="INCLUDE 'grids.bdf'\n", grids_bdf=GRIDS), read,
        answer((4, 1, 0, 0), 1.0, ONE | {"skin": 1})),
    Row(DOOR, "Nastran's guide", "a solid", written("a.bdf", GRIDS + "CTETRA,1,5,1,2,3,4\n"), read,
        Refused(("kind CTETRA", "mesh the middle surfaces"))),
    Row(DOOR, "Nastran's guide", "lines that repeat", written("a.bdf", f"{GRIDS}=,*1,=,*1.,==\n=2\n{QUAD}\n"), read,
        Refused(("fields that repeat", "write all its cards"))),
    Row(DOOR, "Nastran's guide", "superelements", written("a.bdf", f"BEGIN BULK\n{GRIDS}{QUAD}\nBEGIN SUPER=1\n"), read,
        Refused(("superelements", "one plain model"))),
    Row(DOOR, "Nastran's guide", "an included file that is not there",
        written("a.bdf", f"INCLUDE 'b.bdf'\n{GRIDS}{QUAD}\n"), read,
        Refused(("a.bdf includes b.bdf, which is not beside it", "bring the file"))),
    Row(DOOR, "Patran, kept", "a name of a property",
        written("a.bdf", f'$ Pset: "skin" will be imported as: "pshell.5"\n{GRIDS}{QUAD}\n'), read,
        answer((4, 1, 0, 0), 1.0, ONE | {"skin": 1})),
    Row(DOOR, "Nastran's guide", "a number of an element with a point",
        written("a.bdf", f"{GRIDS}{QUAD.replace('1', '1.', 1)}\n"), read, Refused(("'1.' is no whole number",))),
    Row(DOOR, "Nastran's guide", "three corners of four", written("a.bdf", f"{GRIDS}{QUAD[:-2]}\n"), read,
        Refused(("element 1 has the nodes [1, 2, 3, 0], of which a corner is not in the file",))),
    Row(DOOR, "Nastran's guide", "a comma behind the columns", written("a.bdf", f"{GRIDS}GRID    5,,0.,1.\n"), read,
        Refused(("no name of a card",))),
    Row(DOOR, "Nastran's guide", "a property for all bars, behind them",
        written("a.bdf", f"{GRIDS}{QUAD}\nCBAR,5,,1,2\nBAROR,,7,,,0.,0.,1.\n"), read,
        answer((4, 1, 0, 1), 1.0, ONE | {"property:7": 1})),
    Row(DOOR, "Nastran's guide", "a node that is not there", written("a.bdf", f"{GRIDS}{QUAD[:-1]}9\n"), read,
        Refused(("[9]", "write the whole file"))),
    *(
        Row(DOOR, "Abaqus's guide", case, written("a.inp", NODES + SHELLS + text), read,
            answer((9, 4, 0, 0) if "again" in case else (6, 2, 0, 0), 4.0 if "again" in case else 2.0,
                   {"SKIN": 2} | sets, told))
        for case, (text, sets, told) in ABAQUS.items()
    ),
    Row(DOOR, "Abaqus's guide", "a corner twice: a triangle",
        written("a.inp", NODES + SHELLS.replace("2,2,3,6,5", "2,2,3,6,6")), read,
        answer((6, 1, 1, 0), 1.5, {"SKIN": 2})),
    Row(DOOR, "Abaqus's guide", "a parameter", written("a.inp", NODES.replace("2,0,0", "<L>,0,0") + SHELLS), read,
        Refused(("has <L> on a card *NODE", "write the deck with them"))),
    Row(DOOR, "Abaqus's guide", "two *NODE cards", written("a.inp", NODES.replace("6,", "*NODE\n6,") + SHELLS), read,
        answer((6, 2, 0, 0), 2.0, {"SKIN": 2})),
    Row(DOOR, "Abaqus's guide", "nodes and all in other files",
        written("a.inp", "*INCLUDE, INPUT=b.inp\n" + SHELLS, b_inp="*NODE, INPUT=c.txt\n", c_txt=NODES[6:]), read,
        answer((6, 2, 0, 0), 2.0, {"SKIN": 2})),
    Row(DOOR, "Abaqus/CAE, kept", "two instances of a part", written("a.inp", INSTANCES), read,
        answer((8, 2, 0, 0), 2.0,
               {"right": 1, "Set-1": 2, "Plate-1.Set-1": 1, "Plate-2.Set-1": 1, "nodes root": 3})),
    Row(DOOR, "Abaqus/CAE, kept", "a point of the assembly, beside instances' nodes and sets",
        written("a.inp", INSTANCES.replace("*End Assembly", "*Node\n1, 0., 0., 2.\n*Element, type=B31, elset=mast\n"
                "1, 1, Plate-1.1\n*Elset, elset=left, instance=Plate-1\n set-1,\n*End Assembly")), read,
        answer((9, 2, 0, 1), 2.0, {"right": 1, "Set-1": 2, "Plate-1.Set-1": 1, "Plate-2.Set-1": 1, "nodes root": 3,
                                   "mast": 1, "left": 1})),
    Row(DOOR, "Abaqus/CAE, mangled", "an instance turned about a point",
        written("a.inp", INSTANCES.replace("0., 1., 90.", "0., 1e-200, 90.")), read,
        Refused(("turned about a line through one point, [2.0, 0.0, 0.0]",))),
    Row(DOOR, "Abaqus's guide", "a node that is not there", written("a.inp", NODES + SHELLS.replace("6,5", "9,5")),
        read,
        Refused(("element 2", "[2, 3, 9, 5]"))),
    Row(DOOR, "Abaqus's guide", "an axisymmetric element", written("a.inp", NODES + SHELLS.replace("S4", "CAX4")),
        read,
        Refused(("kind CAX4", "expected shells"))),
    *(
        Row(DOOR, "Abaqus's and CalculiX's guides", name, written("a.inp", element(name)), read,
            answer((4, 1, 0, 0) if nodes is EIGHT else (3, 0, 1, 0), 4.0 if nodes is EIGHT else 2.0, {"SKIN": 1}))
        for name, nodes in (QUADRATIC | LINEAR).items()
    ),
    *(
        Row(DOOR, "meshio 5.3", f"{kind} in {name}", meshio_file(name, kind), read,
            answer((4, 1, 0, 0) if kind.startswith("quad") else (3, 0, 1, 0), 4.0 if kind.startswith("quad") else 2.0,
                   {"SKIN": 1}))
        for name, kind in (("a.inp", "quad"), ("a.inp", "triangle"), ("a.inp", "quad8"), ("a.inp", "triangle6"))
    ),
    *(
        Row(DOOR, "gmsh 4.15", f"one surface in two groups, {name}, order {order}", gmsh_file(name, order), read,
            answer((8, 0, 8, 0), 2.0, GROUPS))
        for name, order in (("a2.msh", 1), ("a2.msh", 2), ("a4.msh", 1), ("a4.msh", 2))
    ),
    *(
        Row(DOOR, "gmsh 4.15", f"version {version}", gmsh_file(name), read,
            Refused((f"is MSH {version};", "expected MSH 4.1 or 2.2", "Mesh.MshFileVersion")))
        for name, version in (("a1.msh", 1), ("a40.msh", 4))
    ),
    Row(DOOR, "gmsh 4.15", "elements without a group saved too", gmsh_file("all.msh"), read,
        Refused(("could not be read as gmsh", "without Mesh.SaveAll"))),
    Row(DOOR, "gmsh 4.15, kept", "nine nodes", written("a.bdf", NINE), read,
        answer((4, 1, 0, 0), 4.0, {"property:1": 1})),
    Row(DOOR, "gmsh 4.15", "short fields", gmsh_file("a.bdf"), read,
        answer((8, 0, 8, 0), 2.0, {"property:1": 4, "property:2": 4}, f"8 {ROUNDED}")),
    Row(DOOR, "gmsh 4.15", "long fields", gmsh_file("a.bdf", is_long=True), read,
        answer((8, 0, 8, 0), 2.0, {"property:1": 4, "property:2": 4})),
    Row(DOOR, "gmsh 4.15", "deck of six nodes", gmsh_file("a.inp", 2), read,
        answer((8, 0, 8, 0), 2.0, GROUPS | {"Surface1": 4, "Surface2": 4})),
    *(
        Row(DOOR, "VTK 9", f"cells of {kind}, {'binary' if is_binary else 'text'}, version {version}",
            vtk_file("a.vtk", kind, is_binary, version), read, VTK_ANSWER)
        for kind in ("i4", "i8", "u1", "u2") for is_binary in (False, True) for version in (42, 51)
    ),
    Row(DOOR, "VTK 9", "real cells", vtk_file("a.vtk", "f8", True),
        lambda path: femlib.read(path).elements_of("region:1"), Refused(("'region' has float64, no whole numbers",))),
    Row(DOOR, "VTK 9", "raw appended", vtk_file("a.vtu", "i8", False), read, VTK_ANSWER),
    Row(DOOR, "VTK 9, kept", "two pieces", written("a.vtu", "<Piece N=1></Piece>\n<Piece N=1></Piece>"), read,
        Refused(("several pieces", "merge them"))),
    Row(DOOR, "VTK 9", "LZ4", vtk_file("a.vtu", "i4", True), read, Refused(("compressed by LZ4", "expected zlib"))),
]  # fmt: skip
