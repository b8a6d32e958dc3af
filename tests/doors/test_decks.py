"""Decks that go out and come back, and what CalculiX makes of them."""

import warnings
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import femlib
from benchmarks.ccx import has_ccx, run_deck
from femlib.errors import InputError, LeftOutWarning
from femlib.export.calculix_results import element_points, read_buckling_factors, read_displacements
from femlib.material import Ply, isotropic_plate, laminate
from femlib.structure import NamedMesh, Structure
from femlib.structure.calculix import write_deck
from tests.doors.decks import GRIDS
from tests.test_femlib.own_meshes import ALUMINIUM, corner_spring, plate_mesh, plate_with_mast

meshio = pytest.importorskip("meshio")
needs_ccx = pytest.mark.skipif(not has_ccx(), reason="CalculiX (ccx) is not installed")
STACK = laminate([Ply(1e11, 1e10, 0.3, 5e9, 5e9, 4e9, 0.001, np.radians(angle), 1600.0) for angle in (0, 90, 30)])


def quietly_read(path: Path) -> NamedMesh:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", LeftOutWarning)
        return femlib.read(path, corners_only=True)


def with_triangles(mesh: Any) -> Any:
    """Return the plate's mesh with its second half of triangles, and names that a deck can and cannot bear."""
    quads, n = mesh.cells[0].data, 12
    halves = np.concatenate([quads[n:][:, [0, 1, 2]], quads[n:][:, [0, 2, 3]]])
    sets = {}
    for name, (own, _) in mesh.cell_sets.items():
        inside = np.isin(np.arange(len(quads)), own)
        sets[name] = [np.flatnonzero(inside[:n]), np.flatnonzero(np.tile(inside[n:], 2)), mesh.cell_sets[name][1]]
    sets |= {name: [np.arange(3), [], []] for name in ("region:1", "two words", "E0", "SKIN", "H\u00fclle")}
    cells = [("quad", quads[:n]), ("triangle", halves), ("line", mesh.cells[1].data)]
    return meshio.Mesh(mesh.points, cells, cell_sets=sets, point_sets=mesh.point_sets)


def stacked() -> Structure:
    mesh = with_triangles(plate_mesh())
    bare = meshio.Mesh(mesh.points[:-2], mesh.cells[:2], cell_sets={k: v[:2] for k, v in mesh.cell_sets.items()})
    bare.point_sets = {name: own for name, own in mesh.point_sets.items() if name != "top"}
    return Structure(femlib.read(bare), {"skin": STACK}, {"left": "clamped"}, ("middle",))


STRUCTURES = {
    "quadrilaterals, beams, a mass": plate_with_mast,
    "a spring": lambda: plate_with_mast(springs=(corner_spring(),), damage=("mast", "foot")),
    "triangles": lambda: Structure(
        femlib.read(with_triangles(plate_mesh())),
        plate_with_mast().sections,
        {"left": "clamped"},
        ("mast",),
        {"top": 2.0},
    ),
    "plies with directions": stacked,
}


@pytest.mark.parametrize("case", STRUCTURES)
@pytest.mark.parametrize("analysis", ["linear", "frequencies"])
def test_a_deck_of_femlib_is_read_back_as_the_same_structure(case: str, analysis: Any, tmp_path: Path) -> None:
    sound = STRUCTURES[case]()
    load = sound.point_load("right", (0.0, 1.0, 5.0))
    write_deck(sound, tmp_path / "own.inp", {}, load, analysis=analysis)
    mesh = quietly_read(tmp_path / "own.inp")
    again = Structure(mesh, sound.sections, sound.supports, sound.damage, sound.masses, sound.springs)
    np.testing.assert_array_equal(again.point_load("right", (0.0, 1.0, 5.0)), load)
    stiff = sound.built.stiffness()
    assert abs(again.built.stiffness() - stiff).max() < 1e-9 * abs(stiff).max()
    assert again.total_mass == pytest.approx(sound.total_mass, rel=1e-9)
    assert {"skin", "middle"} <= set(mesh.element_sets)
    for name in {"skin", "middle", "region:1"} & set(sound.mesh.element_sets):
        np.testing.assert_array_equal(mesh.elements_of(name), sound.mesh.elements_of(name))
    text = (tmp_path / "own.inp").read_text()
    assert text.count("has a name that the deck cannot bear") == (4 if "region:1" in sound.mesh.element_sets else 0)


def test_a_deck_that_calculix_stops_at_is_not_written(tmp_path: Path) -> None:
    sections = dict(plate_with_mast().sections) | {"skin": STACK}
    with pytest.raises(InputError, match=r"beside 2 beams and 1 masses, where CalculiX 2.20 stops"):
        write_deck(plate_with_mast(sections=sections), tmp_path / "own.inp", {}, np.zeros(37 * 6))


def strip(n_across: int) -> Structure:
    """A strip of steel, 1 x 0.1 m, clamped at one end."""
    mesh = plate_mesh(n_x=20, n_y=n_across, length=1.0, width=0.1)
    flat = meshio.Mesh(mesh.points[:-2], mesh.cells[:1], cell_sets={"skin": [np.arange(20 * n_across)]})
    flat.point_sets = {name: mesh.point_sets[name] for name in ("left", "right")}
    return Structure(femlib.read(flat), {"skin": isotropic_plate(2.1e11, 0.3, 0.002, 7800.0)}, {"left": "clamped"})


@needs_ccx
@pytest.mark.parametrize("push", [0.02, 20.0, 100.0, 1e6])
def test_a_buckling_factor_is_eulers_whatever_the_load(push: float, tmp_path: Path) -> None:
    """From 70 N on CalculiX leaves the lowest factor of a deck with the whole load out."""
    euler = np.pi**2 * 2.1e11 * (0.1 * 0.002**3 / 12) / 4.0
    own = strip(2)
    write_deck(own, tmp_path / "a.inp", {}, own.point_load("right", (-push, 0, 0)), analysis="buckling", n_modes=2)
    run_deck(tmp_path / "a.inp")
    found = read_buckling_factors(tmp_path / "a.dat")
    assert found[0] * push == pytest.approx(euler, rel=0.02)
    assert found[1] * push == pytest.approx(9.0 * euler, rel=0.03)


BUCKLED = "B U C K L I N G   F A C T O R   O U T P U T\n\n 1 {}\n"


def test_a_factor_far_from_our_own_is_refused(tmp_path: Path) -> None:
    (tmp_path / "a.inp").write_text("** femlib: buckling load times 1.8e+00\n")
    (tmp_path / "a.dat").write_text(BUCKLED.format("1.2-000"))
    assert read_buckling_factors(tmp_path / "a.dat").tolist() == [pytest.approx(2.16)]
    for wrong in ("0.6000000E+00", "9.1000000E+00"):
        (tmp_path / "a.dat").write_text(BUCKLED.format(wrong))
        with pytest.raises(InputError, match="as the lowest buckling factor, femlib 2; expected them within 25 %"):
            read_buckling_factors(tmp_path / "a.dat")
    (tmp_path / "a.inp").unlink()
    with pytest.raises(InputError, match=r"expected the deck of .*, which says how its load was scaled"):
        read_buckling_factors(tmp_path / "a.dat")


def test_a_buckling_deck_that_gives_no_answer_is_refused(tmp_path: Path) -> None:
    narrow, wide = strip(1), strip(2)
    push = (-1.0, 0.0, 0.0)
    with pytest.raises(InputError, match=r"one element wide at element 0 .20 such elements.*two elements across"):
        write_deck(narrow, tmp_path / "a.inp", {}, narrow.point_load("right", push), analysis="buckling")
    with pytest.raises(InputError, match="buckles nothing"):
        write_deck(wide, tmp_path / "a.inp", {}, wide.point_load("right", (0.0, 0.0, 1.0)), analysis="buckling")
    beams = plate_with_mast()
    with pytest.raises(InputError, match="has 2 beams and springs"):
        write_deck(beams, tmp_path / "a.inp", {}, beams.point_load("right", push), analysis="buckling")


def test_numbers_of_calculix_need_no_letter(tmp_path: Path) -> None:
    (tmp_path / "a.dat").write_text("strains\n\n 1 1 -1.600000-117 1.0E-04 0. 2.5D-5 0. 1.5+002\n")
    assert element_points(tmp_path / "a.dat")[0] == [[-1.6e-117, 1e-4, 0.0, 2.5e-5, 0.0, 150.0]]
    (tmp_path / "a.frd").write_text(" -4  DISP\n -1         1 1.00000-101-2.0000E+00 3.00000E+00\n -3\n")
    assert read_displacements(tmp_path / "a.frd", 1).tolist() == [[1e-101, -2.0, 3.0]]


def test_a_file_that_says_what_it_leaves_out_says_it_in_the_mesh_too(tmp_path: Path) -> None:
    (tmp_path / "a.bdf").write_text(GRIDS + "CQUAD4,1,5,1,2,3,4,,.002\nRBE2,7,1,123,2\n")
    with pytest.warns(
        LeftOutWarning, match=r"1 ZOFFS .*, 1 RBE2 \(rigid elements\); give to Structure what of it counts"
    ):
        mesh = femlib.read(tmp_path / "a.bdf")
    assert dict(mesh.left_out) == {"ZOFFS (shells beside their nodes)": "1", "RBE2 (rigid elements)": "1"}
    assert Structure(mesh, {"property:5": ALUMINIUM}, {"property:5": "clamped"}).built.mesh.n_elements == 1
