"""The readers of a structure's files, as the fuzz of files tries them: other programs' meshes, CalculiX's results."""

import contextlib
import functools
import warnings
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import meshio
import numpy as np

import femlib
from benchmarks.readers.file_reader import Reader
from benchmarks.readers.mangling import Generator, mangled_bytes, mangled_numbers, mangled_tokens
from benchmarks.readers.universal import unv
from femlib.errors import FemlibError, LeftOutWarning
from femlib.export.calculix_results import read_displacements, read_frequencies
from femlib.material import isotropic_plate
from femlib.sensors import StrainGauge
from femlib.structure import Structure, calculix

SKIN = isotropic_plate(70e9, 0.33, 0.003, 2700.0)
N_ACROSS = 3
N_POINTS = 8
"""Strains that CalculiX prints of a quadrilateral."""


def _plate() -> meshio.Mesh:
    """Return a plate of nine quadrilaterals with two sets of elements and one of nodes."""
    x, y = np.meshgrid(np.linspace(0.0, 0.3, N_ACROSS + 1), np.linspace(0.0, 0.3, N_ACROSS + 1))
    points = np.column_stack([x.ravel(), y.ravel(), np.zeros(x.size)])
    first = (np.arange(N_ACROSS)[:, None] * (N_ACROSS + 1) + np.arange(N_ACROSS)).ravel()
    quads = np.column_stack([first, first + 1, first + N_ACROSS + 2, first + N_ACROSS + 1])
    return meshio.Mesh(
        points,
        [("quad", quads)],
        cell_sets={"skin": [np.arange(len(quads))], "middle": [np.array([4])]},
        point_sets={"left": np.flatnonzero(points[:, 0] == 0.0)},
        cell_data={"part": [np.arange(len(quads)) // 3]},
    )


def _without_sets(own: meshio.Mesh, **data: object) -> meshio.Mesh:
    return meshio.Mesh(own.points, own.cells, **data)


def _tagged(own: meshio.Mesh) -> meshio.Mesh:
    """Return the mesh as gmsh's, with a physical group of each part."""
    part = own.cell_data["part"][0].astype(np.int32) + 1
    groups = {name: np.array([tag, 2]) for tag, name in enumerate(("one", "two", "three"), start=1)}
    data = {"gmsh:physical": [part], "gmsh:geometrical": [part]}
    return _without_sets(own, cell_data=data, field_data=groups)


BULK = """SOL 101
CEND
BEGIN BULK
CORD2C  1       0       0.0     0.0     0.0     0.0     0.0     1.0
        1.0     0.0     0.0
CORD1R  2       1       2       3
GRID    1       1       1.0     0.0     0.0
GRID    2       1       1.0     90.0    0.0
GRID,3,,0.1,0.2,1.0D0
GRID*   4                               0.5             0.3
*       1.2+0
CQUAD4  1       5       1       2       3       4       30.0    .001
CTRIA3  2       5       1       2       4       1
CBAR    3       7       1       2       0.0     0.0     1.0

SPC1    1       123456  1       THRU    2
CONM2   9       3               1.5
FORCE   3       4               1.0     0.0     0.0     1.0
ENDDATA
"""
PARTS = """*Part, name=P
*Node
1, 0., 0., 0.
2, 0.1, 0., 0.
3, 0.1, 0.1, 0.
4, 0., 0.1, 0.
*Ngen, nset=line
1, 2, 1
*Element, type=S4R, elset=own
1, 1, 2, 3, 4
*Elgen, elset=own
1, 1, 4, 1
*End Part
*Instance, name=A, part=P
0., 0., 1.
0., 0., 0., 0., 0., 1., 30.
*End Instance
*Nset, nset=foot, instance=A, generate
1, 2, 1
*Elset, elset=both
A.1, A.own
"""
WRITTEN: dict[str, Callable[[Path], object]] = {
    "mesh.inp": lambda path: meshio.write(path, _plate()),
    "mesh.msh": lambda path: meshio.write(path, _tagged(_plate()), "gmsh22", binary=False),
    "mesh4.msh": lambda path: meshio.write(path, _tagged(_plate()), "gmsh", binary=True),
    "mesh.bdf": lambda path: meshio.write(path, _without_sets(_plate())),
    "cards.bdf": lambda path: path.write_text(BULK),
    "parts.inp": lambda path: path.write_text(PARTS),
    "mesh.unv": lambda path: path.write_text(unv()),
    "mesh.med": lambda path: meshio.write(path, _without_sets(_plate())),
    "mesh.vtk": lambda path: meshio.write(path, _without_sets(_plate(), cell_data=_plate().cell_data), "vtk42"),
    "mesh5.vtk": lambda path: meshio.write(path, _without_sets(_plate(), cell_data=_plate().cell_data), "vtk51"),
    "mesh.vtu": lambda path: meshio.write(path, _without_sets(_plate(), cell_data=_plate().cell_data)),
}
"""What writes the plate, by the name of the file."""


def mangled_text(rng: Generator, content: bytes) -> bytes:
    """Return a text with numbers changed where they stand, or whole tokens and lines."""
    return (mangled_numbers if rng.random() < 0.7 else mangled_tokens)(rng, content)


def make_mesh(name: str) -> Callable[[int, Path], None]:
    """Return what writes the plate in the format of a file's name."""

    def write(number: int, folder: Path) -> None:
        WRITTEN[name](folder / name)

    return write


def read_mesh(name: str) -> Callable[[Generator, Path], None]:
    """Return what reads a mesh, and bends it where it still is a structure."""

    def read(rng: Generator, folder: Path) -> None:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", LeftOutWarning)  # a mangled card may be one that is left out
            mesh = femlib.read(folder / name)
        sets = {name: mask for name, mask in mesh.element_sets.items() if mask.any()} or {"all": mesh.quads[:, 0] >= 0}
        with contextlib.suppress(FemlibError):
            named = replace(mesh, element_sets=sets, node_sets={"foot": np.array([0, 1])})
            structure = Structure(
                named, sections=dict.fromkeys(sets, SKIN), supports={"foot": "clamped"}, damage=list(sets)[:1]
            )
            assert np.isfinite(structure.solve({}, structure.gravity())).all()

    return read


@functools.cache
def _structure() -> Structure:
    return Structure(femlib.read(_plate()), sections={"skin": SKIN}, supports={"left": "clamped"}, damage=["middle"])


def make_results(number: int, folder: Path) -> None:
    """Write results as CalculiX prints them: strains and frequencies (.dat), displacements (.frd)."""
    rng = np.random.default_rng([96, number])
    rows = [" strains (elem, integ.pnt.,exx,eyy,ezz,exy,exz,eyz) for set GAUGES and time  1.0\n"]
    for element in range(1, N_ACROSS**2 + 1):
        for point in range(1, N_POINTS + 1):
            rows.append(f"{element:10d}{point:4d}" + "".join(f"{v:14.6E}" for v in 1e-4 * rng.normal(size=6)))
    (folder / "strains.dat").write_text("\n".join(rows) + "\n")
    modes = [f"{k:7d} {9.0 * k:.7E} {3.0 * k:.7E} {0.5 * k:.7E} 0.0000000E+00" for k in range(1, 4)]
    (folder / "modes.dat").write_text("     E I G E N V A L U E   O U T P U T\n\n" + "\n".join(modes) + "\n")
    values = 1e-3 * rng.normal(size=(_structure().built.mesh.nodes.shape[0], 3))
    nodes = [f" -1{k:10d}" + "".join(f"{v:12.5E}" for v in row) for k, row in enumerate(values, start=1)]
    (folder / "wing.frd").write_text("\n".join([" -4  DISP        4    1", *nodes, " -3", " 9999"]) + "\n")


def read_strains(rng: Generator, folder: Path) -> None:
    """Read a gauge from a result."""
    gauge = StrainGauge("g", np.array([0.15, 0.15, 0.0]), np.array([1.0, 0.0, 0.0]), ("skin",))
    assert np.isfinite(calculix.read_gauges(_structure(), folder / "strains.dat", [gauge])).all()


def read_modes(rng: Generator, folder: Path) -> None:
    """Read frequencies from a result."""
    assert np.isfinite(read_frequencies(folder / "modes.dat")).all()


def read_motion(rng: Generator, folder: Path) -> None:
    """Read displacements from a result."""
    assert np.isfinite(read_displacements(folder / "wing.frd", _structure().built.mesh.nodes.shape[0])).all()


STRUCTURES = {
    f"mesh {name}": Reader(
        make_mesh(name),
        name,
        mangled_bytes if {*"45"} & {*name} or name.endswith("med") else mangled_text,
        read_mesh(name),
        n_made=1,
    )
    for name in WRITTEN
} | {
    "CalculiX, strains of a structure": Reader(make_results, "strains.dat", mangled_text, read_strains),
    "CalculiX, frequencies": Reader(make_results, "modes.dat", mangled_text, read_modes),
    "CalculiX, displacements": Reader(make_results, "wing.frd", mangled_text, read_motion),
}
