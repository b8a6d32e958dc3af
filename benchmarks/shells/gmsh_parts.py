"""Parts that gmsh meshes with triangles: strains of femlib beside CalculiX's S8R on fine quadrilaterals.

    python -m benchmarks.shells.gmsh_parts        needs `pip install gmsh` and `ccx`

A curved panel under pressure, a bracket of two plates and a gusset, and a T-joint whose stem is pulled aside. Gauges
stand on both sides. Each mesh of triangles is answered or refused by the estimates that every call makes; the reference
is a mesh of quadrilaterals of 4 mm (S8R), on which CalculiX's strains and femlib's are averaged over the same elements.
"""

import tempfile
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import gmsh
import numpy as np

from benchmarks.ccx import need_ccx, run_deck
from benchmarks.main_program import run_main
from femlib.arrays import FloatArray
from femlib.errors import SolveError
from femlib.material import isotropic_plate
from femlib.sensors import StrainGauge
from femlib.structure import Structure, read
from femlib.structure.calculix import read_gauges, write_deck
from octmip.interfaces.report.markdown import markdown_table

SECTION = isotropic_plate(70e9, 0.33, 0.004, 2700.0)
SIZES = (0.04, 0.02, 0.01)
"""Sides of triangles [m]."""
FINE = 0.004
"""Side of the quadrilaterals of the reference [m]."""


@dataclass(frozen=True, slots=True)
class Part:
    """A part.

    Attributes
    ----------
    draw : callable
        Draws its surfaces and returns them by name, and its lines by name, in gmsh.
    load : callable
        Nodal forces (n_dofs,) of its structure.
    gauges : mapping
        Place, direction and set of each gauge.
    """

    draw: Callable[[], tuple[Mapping[str, list[int]], Mapping[str, list[int]]]]
    load: Callable[[Structure], FloatArray]
    gauges: tuple[tuple[tuple[float, float, float], tuple[float, float, float], str], ...]


def main() -> None:
    """Print the table."""
    need_ccx()
    print(markdown_table([row for name in PARTS for row in part_rows(name)]))


def part_rows(name: str) -> Iterator[dict[str, Any]]:
    """Yield what each mesh of triangles of a part answers beside the reference."""
    part = PARTS[name]
    gauges = [
        StrainGauge(f"{k}{'+' if side > 0 else '-'}", np.array(place), np.array(along), (patch,), side)
        for k, (place, along, patch) in enumerate(part.gauges)
        for side in (1.0, -1.0)
    ]
    wanted = calculix_strains(meshed(part, FINE, is_quads=True), part, gauges)
    for size in SIZES:
        structure = meshed(part, size, is_quads=False)
        row = {"part": name} | answered(structure, part.load(structure), gauges, wanted)
        print(row, flush=True)
        yield row


def answered(structure: Structure, load: FloatArray, gauges: list[StrainGauge], wanted: FloatArray) -> dict[str, Any]:
    """Return how far a mesh's strains are from those wanted (n_gauges,), its estimate, and whether it is refused."""
    found, largest = structure.strain_microstrain({}, load, gauges, 9.0, 9.0), float(np.abs(wanted).max())
    row: dict[str, Any] = {"triangles": len(structure.mesh.trias)}
    row["off, rms %"] = round(100 * float(np.sqrt(np.mean((found - wanted) ** 2))) / largest, 2)
    row["off at most %"] = round(100 * float(np.abs(found - wanted).max()) / largest, 2)
    row["estimate %"] = round(100 * found.error, 2)
    try:
        structure.strain_microstrain({}, load, gauges)
    except SolveError:
        return row | {"answer": "refused"}
    return row | {"answer": "given"}


def calculix_strains(structure: Structure, part: Part, gauges: list[StrainGauge]) -> FloatArray:
    """Return CalculiX's gauge strains (n_gauges,) [microstrain]."""
    with tempfile.TemporaryDirectory() as folder:
        deck = Path(folder) / "wing.inp"
        write_deck(structure, deck, {}, part.load(structure), gauges)
        run_deck(deck)
        return read_gauges(structure, deck.with_suffix(".dat"), gauges)


def meshed(part: Part, size: float, is_quads: bool) -> Structure:
    """Return a part as gmsh meshes it."""
    gmsh.initialize()
    try:
        gmsh.option.setNumber("General.Verbosity", 1)
        surfaces, lines = part.draw()
        for dimension, named in ((2, surfaces), (1, lines)):
            for name, tags in named.items():
                gmsh.model.addPhysicalGroup(dimension, tags, name=name)
        gmsh.option.setNumber("Mesh.MeshSizeMin", size)
        gmsh.option.setNumber("Mesh.MeshSizeMax", size)
        if is_quads:
            gmsh.option.setNumber("Mesh.RecombineAll", 1)
            gmsh.option.setNumber("Mesh.Algorithm", 8)
        gmsh.model.mesh.generate(2)
        with tempfile.TemporaryDirectory() as folder:
            gmsh.write(f"{folder}/part.msh")
            mesh = read(f"{folder}/part.msh")
    finally:
        gmsh.finalize()
    return Structure(mesh, dict.fromkeys(surfaces, SECTION), {"held": "clamped"})


def _edges_at(places: Callable[[FloatArray], bool]) -> list[int]:
    """Return the lines of the model whose boxes' middles lie at some places."""
    boxes = {tag: np.array(gmsh.model.getBoundingBox(1, tag)).reshape(2, 3) for _, tag in gmsh.model.getEntities(1)}
    return [tag for tag, box in boxes.items() if places(box)]


def _plates(corners: Mapping[str, list[tuple[float, float, float]]]) -> dict[str, list[int]]:
    """Return the surfaces by name of flat plates that share their edges."""
    surfaces = []
    for points in corners.values():
        tags = [gmsh.model.occ.addPoint(*point) for point in points]
        sides = [gmsh.model.occ.addLine(a, b) for a, b in zip(tags, tags[1:] + tags[:1], strict=True)]
        surfaces.append((2, gmsh.model.occ.addPlaneSurface([gmsh.model.occ.addCurveLoop(sides)])))
    _, pieces = gmsh.model.occ.fragment(surfaces, [])
    gmsh.model.occ.synchronize()
    return {name: [tag for _, tag in own] for name, own in zip(corners, pieces, strict=True)}


def _panel() -> tuple[dict[str, list[int]], dict[str, list[int]]]:
    """Draw a part of a cylinder of radius 1 m, 0.6 m along x and 0.5 m of arc."""
    occ, half = gmsh.model.occ, 0.25
    ends = [occ.addPoint(0.0, np.sin(a), np.cos(a) - 1.0) for a in (-half, half)]
    arc = occ.addCircleArc(ends[0], occ.addPoint(0.0, 0.0, -1.0), ends[1])
    swept = occ.extrude([(1, arc)], 0.6, 0.0, 0.0)
    occ.synchronize()
    skin = [tag for dimension, tag in swept if dimension == 2]
    return {"skin": skin}, {"held": _edges_at(lambda box: bool(np.ptp(box[:, 0]) < 1e-3))}


def _bracket() -> tuple[dict[str, list[int]], dict[str, list[int]]]:
    """Draw a wall and a shelf of 0.3 x 0.2 m with a gusset between; the wall's upper and lower edges are held."""
    found = _plates(
        {
            "wall": [(0, -0.1, -0.2), (0, 0.1, -0.2), (0, 0.1, 0.2), (0, -0.1, 0.2)],
            "shelf": [(0, -0.1, 0), (0.3, -0.1, 0), (0.3, 0.1, 0), (0, 0.1, 0)],
            "gusset": [(0, 0, 0), (0, 0, -0.15), (0.2, 0, 0)],
        }
    )
    held = _edges_at(lambda box: bool(np.ptp(box[:, 2]) < 1e-3 and abs(abs(box[0, 2]) - 0.2) < 1e-3))
    return found, {"held": held, "tip": _edges_at(lambda box: bool(box[0, 0] > 0.299))}


def _t_joint() -> tuple[dict[str, list[int]], dict[str, list[int]]]:
    """Draw a flange of 0.4 x 0.2 m with a stem 0.2 m high on its middle line; the flange's ends are held."""
    found = _plates(
        {
            "flange": [(-0.2, -0.1, 0), (0.2, -0.1, 0), (0.2, 0.1, 0), (-0.2, 0.1, 0)],
            "stem": [(0, -0.1, 0), (0, 0.1, 0), (0, 0.1, 0.2), (0, -0.1, 0.2)],
        }
    )
    held = _edges_at(lambda box: bool(np.ptp(box[:, 0]) < 1e-3 and abs(abs(box[0, 0]) - 0.2) < 1e-3))
    return found, {"held": held, "top": _edges_at(lambda box: bool(box[0, 2] > 0.199))}


X, Y, Z = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)
PARTS = {
    "panel": Part(
        _panel,
        lambda own: own.pressure("skin", 5e3),
        (((0.3, 0.0, 0.0), X, "skin"), ((0.3, 0.0, 0.0), Y, "skin"), ((0.2, np.sin(0.1), np.cos(0.1) - 1), X, "skin")),
    ),
    "bracket": Part(
        _bracket,
        lambda own: own.line_load("tip", (0.0, 0.0, -500.0)),
        (((0.12, 0.05, 0.0), X, "shelf"), ((0.24, 0.0, 0.0), X, "shelf"), ((0.0, 0.05, 0.1), Z, "wall")),
    ),
    "T-joint": Part(
        _t_joint,
        lambda own: own.line_load("top", (500.0, 0.0, 0.0)),
        (((0.0, 0.0, 0.08), Z, "stem"), ((0.08, 0.0, 0.0), X, "flange"), ((-0.08, 0.03, 0.0), X, "flange")),
    ),
}


if __name__ == "__main__":
    run_main(main)
