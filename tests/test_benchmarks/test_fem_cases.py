"""The wing's benchmark cases at sizes that take a second each: their lines and their tables."""

import sys
from types import ModuleType

import meshio
import numpy as np
import pytest

from benchmarks.cases.fem import dataset as fem_dataset
from benchmarks.cases.fem import mesh as fem_mesh
from benchmarks.cases.fem import shells as fem_shells
from benchmarks.ccx import has_ccx
from benchmarks.shells.case import DIAGONALS
from benchmarks.shells.problems import CONVERGING, LAMINATED, STRIPS
from femlib.sensors import StrainGauge
from femlib.structure import Structure, read
from tests.test_femlib.own_meshes import ALUMINIUM

needs_calculix = pytest.mark.skipif(not has_ccx(), reason="CalculiX (ccx) is not installed")


def test_mesh_lines_shrink_with_the_step():
    lines = list(fem_mesh.compared((0.25, 0.4), 0.6))
    assert lines[0]["pristine_rms"] > lines[1]["pristine_rms"]
    assert lines[1]["times_finer"] > 1.5
    assert "| 0.4 |" in fem_mesh.summary(lines)


def test_shell_lines_make_tables_and_a_picture(tmp_path):
    roof, hook = "Scordelis-Lo roof", "Raasch's hook"
    problems = {roof: CONVERGING[roof], hook: lambda n: STRIPS[hook](n // 4)}
    solvers = ["femlib quadrilateral", "femlib triangle", "pyfe3d Quad4", "pyfe3d Tria3DSG"]
    lines = [*fem_shells.compared(problems, (4,), solvers), *fem_shells.beams(solvers[:1])]
    lines.append(fem_shells.panels(2, 8, DIAGONALS[0]))
    table = fem_shells.summary(lines)
    assert f"| {roof} | 4 x 4 | 1.047 | " in table
    assert f"| {hook} | 9 x 1 | 0.906 | " in table
    assert "| rectangular, in plane | 0.993 |" in table
    assert "2 random panels, first diagonal, 8 a side: " in table
    fem_shells.picture(lines, tmp_path / "rates.svg")
    assert roof in (tmp_path / "rates.svg").read_text()


@pytest.mark.parametrize(("n_x", "answer"), [(4, "refused"), (16, "given")])
def test_triangles_are_judged_beside_a_reference_and_refused_where_they_are_coarse(monkeypatch, n_x, answer):
    monkeypatch.setitem(sys.modules, "gmsh", ModuleType("gmsh"))  # it draws meshes, this one is there
    from benchmarks.shells.gmsh_parts import answered

    x, y = np.meshgrid(np.linspace(0.0, 1.0, n_x + 1), np.linspace(0.0, 0.1, n_x // 4 + 1))
    first = (np.arange(n_x // 4)[:, None] * (n_x + 1) + np.arange(n_x)).ravel()
    sides = np.concatenate([first + np.array(k)[:, None] for k in ((0, 1, n_x + 2), (0, n_x + 2, n_x + 1))], axis=1).T
    points = np.column_stack([x.ravel(), y.ravel(), np.zeros(x.size)])
    ends = {"left": np.flatnonzero(points[:, 0] == 0.0), "right": np.flatnonzero(points[:, 0] == 1.0)}
    mesh = meshio.Mesh(points, [("triangle", sides)], cell_sets={"skin": [np.arange(len(sides))]}, point_sets=ends)
    strip = Structure(read(mesh), {"skin": ALUMINIUM}, {"left": "clamped"})
    gauges = [
        StrainGauge(n, np.array([0.3, 0.05, 0.0]), np.array([1.0, 0, 0]), ("skin",), s)
        for n, s in (("t", 1), ("b", -1))
    ]
    load = strip.point_load("right", (0.0, 0.0, 0.2))
    found = np.asarray(strip.strain_microstrain({}, load, gauges, 9.0, 9.0))
    row = answered(strip, load, gauges, found + np.array([0.0, 0.1]) * np.abs(found).max())
    assert row["triangles"] == 2 * n_x * (n_x // 4)
    assert row["answer"] == answer
    assert row["off at most %"] == pytest.approx(10.0, rel=0.2)
    assert row["off, rms %"] == pytest.approx(row["off at most %"] / np.sqrt(2.0), abs=0.02)


@needs_calculix
def test_calculix_solves_the_same_cases_or_says_why_not():
    problems = {name: LAMINATED[name] for name in ("Pagano [0/90/90/0], a/h 10",)}
    lines = list(fem_shells.compared(problems, (4,), ["CalculiX S4", "CalculiX S8R"]))
    assert "laminate 0 has 4 plies; expected 1 in linear shells" in lines[0]["outcome"]
    assert lines[1]["ratio"] == pytest.approx(0.84, abs=0.05)
    assert "CalculiX S4 (-): laminate 0 has 4 plies" in fem_shells.summary(lines)


def test_dataset_lines_count_rows_and_memory():
    lines = [fem_dataset.streamed(model, 20, 3, 1, 0.25) for model in ("full wing", "reduced wing")]
    assert [line["rows"] for line in lines] == [60, 60]
    assert lines[0]["peak_megabytes"] > 50
    assert "| reduced wing, 20 states x 3 readings | 60 | 1 |" in fem_dataset.summary(lines)
