"""Wrong meshes and structures: each is refused in one sentence that says what, where, got, expected and the cure."""

from dataclasses import replace

import meshio
import numpy as np
import pytest

from femlib.errors import FemlibError
from femlib.material import Ply, isotropic_plate, laminate
from femlib.sensors import StrainGauge
from femlib.structure import Spring, Structure, parts, read, rectangular_beam, reduce, write_vtu
from femlib.structure.calculix import write_deck
from tests.test_femlib.own_meshes import ALUMINIUM, plate_mesh, plate_with_mast
from tests.test_femlib.test_mesh_files import DECK

SECTIONS = {"skin": ALUMINIUM, "mast": rectangular_beam(70e9, 0.33, 0.01, 0.02, (1, 0, 0), 2700.0)}
PLATE = plate_with_mast()


def changed(points=None, cells=None):
    """The plate's mesh with other points or cells."""
    mesh = plate_mesh()
    own = mesh.cells if cells is None else cells
    return meshio.Mesh(mesh.points if points is None else points, own, cell_sets=mesh.cell_sets)


def built(mesh, sections=None, supports=None, **others):
    return Structure(read(mesh), sections or SECTIONS, supports or {"skin": "clamped"}, **others)


def not_finite():
    points = plate_mesh().points.copy()
    points[3, 1] = np.nan
    return read(changed(points=points))


def short_beam():
    points = plate_mesh().points.copy()
    points[-1] = points[-2]
    return built(changed(points=points))


def flipped():
    """One element is turned over, in a set of its own: no set of the file has both sides, but the pressure does."""
    mesh = plate_mesh()
    mesh.cells[0].data[3] = mesh.cells[0].data[3][::-1].copy()
    mesh.cell_sets["turned"] = [np.array([3]), np.zeros(0, dtype=int)]
    return built(mesh).pressure("skin", 100.0)


def written(folder, text, name="mesh.inp", **options):
    (folder / name).write_text(text)
    return read(folder / name, **options)


def soft():
    """Megapascals where pascals are expected."""
    plate = plate_with_mast(sections=SECTIONS | {"skin": isotropic_plate(70e3, 0.33, 0.003)}, damage=())
    return plate.solve({}, plate.pressure("skin", 1000.0))


CASES = {
    "unknown set": (lambda f: built(plate_mesh(), {"skinn": ALUMINIUM}), "'skinn' is not in the mesh; expected one"),
    "unknown node set": (lambda f: plate_with_mast(supports={"lefd": "clamped"}), "'lefd' is not in the mesh"),
    "empty set": (lambda f: built(plate_mesh(), SECTIONS | {"nothing": ALUMINIUM}), "'nothing' is empty"),
    "volumes": (lambda f: read(meshio.Mesh(np.eye(4, 3), [("tetra", np.arange(4)[None])])), "shells and lines alone"),
    "quadratic": (lambda f: read(meshio.Mesh(np.eye(6, 3), [("triangle6", np.arange(6)[None])])), "corners_only"),
    "lone node": (
        lambda f: read(changed(points=np.vstack([plate_mesh().points, [9.0, 9.0, 9.0]]))),
        "node 37 at .* belongs to no element",
    ),
    "no support": (lambda f: plate_with_mast(supports={}), "has no support"),
    "too few supports": (lambda f: plate_with_mast(supports={"corner": "pinned"}), "can still move as a rigid body"),
    "wrong direction": (lambda f: plate_with_mast(supports={"left": "w"}), "expected 'clamped', 'pinned' or some"),
    "beam of no length": (lambda f: short_beam(), "has a length of 0 m"),
    "beam along its axis": (
        lambda f: built(plate_mesh(), SECTIONS | {"mast": rectangular_beam(7e10, 0.3, 0.1, 0.1, (0, 0, 1))}),
        "runs along its section's y_axis",
    ),
    "gauge on beams": (
        lambda f: PLATE.strain_rows([StrainGauge("g", (0.3, 0.2, 0.0), (1, 0, 0), ("mast",))]),
        "which hold beams alone",
    ),
    "no section": (lambda f: built(plate_mesh(), {"middle": ALUMINIUM}), "16 shells have no section"),
    "two sections": (lambda f: built(plate_mesh(), SECTIONS | {"middle": ALUMINIUM}), "both have a section"),
    "plate as beam": (lambda f: built(plate_mesh(), {"skin": SECTIONS["mast"]}), "holds shells alone; expected lines"),
    "free lines": (lambda f: built(plate_mesh(), {"skin": ALUMINIUM}), "lines end at nodes of no shell"),
    "pressure on beams": (lambda f: PLATE.pressure("mast", 1.0), "holds lines alone"),
    "pressure on both sides": (lambda f: flipped(), "toward opposite sides"),
    "line load on an area": (lambda f: PLATE.line_load("skin", (1, 0, 0)), "no line"),
    "line load on nodes of an area": (
        lambda f: built(
            meshio.Mesh(plate_mesh().points, plate_mesh().cells, cell_sets=plate_mesh().cell_sets,
                        point_sets={"all": np.arange(35)})).line_load("all", (1, 0, 0)),
        "holds all corners of shell 0",
    ),
    "damage without stiffness": (
        lambda f: built(
            meshio.Mesh(plate_mesh().points[:35], [plate_mesh().cells[0], ("line", np.array([[0, 1]]))],
                        cell_sets={"skin": [np.arange(24), []], "edge": [[], [0]]}), {"skin": ALUMINIUM},
            damage=["edge"]),
        "have no section and so no stiffness|has no section",
    ),
    "overlapping damage": (lambda f: plate_with_mast(damage=("skin", "middle")), "share 8 elements"),
    "damage in percent": (lambda f: PLATE.solve({"middle": 40}, PLATE.gravity()), "give it as a fraction"),
    "no such damage": (lambda f: PLATE.solve({"centre": 0.4}, PLATE.gravity()), "correct the parameter's name"),
    "not a mesh": (lambda f: written(f, "hello"), "has no node"),
    "not a gmsh file": (lambda f: written(f, "hello", "mesh.msh"), "could not be read as gmsh"),
    "a vtu file cut off": (lambda f: written(f, "<VTKFile", "mesh.vtu"), "could not be read as vtu"),
    "no file": (lambda f: read(f / "no.msh"), "cannot be read"),
    "unknown ending": (lambda f: written(f, "x", "mesh.step"), "ends in '.step'"),
    "set of what is not there": (lambda f: written(f, DECK + "*ELSET, ELSET=X\n99\n"), "names '99'"),
    "an included file": (lambda f: written(f, DECK + "*INCLUDE, INPUT=o\n"), "includes o, which is not beside it"),
    "unit": (lambda f: written(f, DECK, unit="km"), "unit is 'km'; expected one of"),
    "not finite": (lambda f: not_finite(), "node 3 lies at"),
    "millimetres": (lambda f: built(changed(points=1e3 * plate_mesh().points)), "read\\(..., unit='mm'\\)"),
    "megapascals": (lambda f: soft(), "moduli in Pa"),
    "mass below zero": (lambda f: plate_with_mast(masses={"top": -1.0}), "mass at 'top' is -1.0 kg"),
    "no mass": (
        lambda f: plate_with_mast(
            sections={"skin": isotropic_plate(7e10, 0.3, 0.003), "mast": replace(SECTIONS["mast"], density=0.0)},
            masses={},
        ).natural_modes(1),
        "has no mass",
    ),
    "spring of two stiffnesses": (
        lambda f: plate_with_mast(springs=(Spring("s", "top", (1.0, 2.0)),)),
        "spring 's' stiffness has shape",
    ),
    "spring of sets": (lambda f: plate_with_mast(springs=(Spring("s", "left", 1.0, to="top"),)), "joins 5 and 1"),
    "laminate across its axis": (
        lambda f: plate_with_mast(
            sections=SECTIONS | {"skin": laminate([Ply(1e11, 1e10, 0.3, 5e9, 5e9, 5e9, 0.003)])}, axis=(0, 0, 1)
        ),
        "choose another axis",
    ),
    "no damage to reduce": (
        lambda f: reduce(plate_with_mast(damage=()), PLATE.gravity(), []),
        "no damage region",
    ),
    "picture's ending": (lambda f: write_vtu(PLATE, f / "x.png", {}, PLATE.gravity()), "expected .vtu"),
    "deck's ending": (lambda f: write_deck(PLATE, f / "x.txt", {}, PLATE.gravity()), "expected .inp"),
}  # fmt: skip


@pytest.mark.parametrize("name", CASES)
def test_a_wrong_structure_is_refused_in_one_sentence(name, tmp_path):
    make, sentence = CASES[name]
    with pytest.raises(FemlibError, match=sentence) as caught:
        make(tmp_path)
    message = str(caught.value)
    assert "\n" not in message
    assert "; " in message, f"no cure: {message}"


def test_a_damage_region_that_fills_the_memory_is_refused(monkeypatch):
    monkeypatch.setattr(parts, "MOST_CARRIED", 5000)
    with pytest.raises(FemlibError, match=r"'middle' has 90 degrees of freedom and 60 at its border.*; divide it"):
        plate_with_mast()


def test_the_mesh_in_millimetres_is_the_mesh_in_metres():
    found = read(changed(points=1e3 * plate_mesh().points), unit="mm")
    np.testing.assert_allclose(found.nodes, plate_mesh().points)
