"""The wing's benchmark cases at sizes that take a second each: their lines and their tables."""

import shutil

import pytest

from benchmarks.cases.fem import calculix as fem_calculix
from benchmarks.cases.fem import calibration as fem_calibration
from benchmarks.cases.fem import dataset as fem_dataset
from benchmarks.cases.fem import mesh as fem_mesh
from benchmarks.cases.fem import shells as fem_shells
from benchmarks.shells.case import DIAGONALS
from benchmarks.shells.problems import CONVERGING, LAMINATED, STRIPS
from femlib.wing import uav_wing

needs_calculix = pytest.mark.skipif(shutil.which("ccx") is None, reason="CalculiX (ccx) is not installed")


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


@needs_calculix
def test_calculix_solves_the_same_cases_or_says_why_not():
    problems = {name: LAMINATED[name] for name in ("Pagano [0/90/90/0], a/h 10",)}
    lines = list(fem_shells.compared(problems, (4,), ["CalculiX S4", "CalculiX S8R"]))
    assert "laminate 0 has 4 plies; expected 1 in linear shells" in lines[0]["outcome"]
    assert lines[1]["ratio"] == pytest.approx(0.84, abs=0.05)
    assert "CalculiX S4 (-): laminate 0 has 4 plies" in fem_shells.summary(lines)


@needs_calculix
def test_calculix_lines_are_small_numbers():
    line = fem_calculix.linear({"mu1": 0.5}, 0.25)
    assert line["usable_rms"] < 10.0
    assert "| linear | mu1 50% | 0.25 |" in fem_calculix.summary([line])


def test_lines_of_large_deflection_are_changes_in_percent(monkeypatch):
    wing = uav_wing(refinement=0.25)
    monkeypatch.setattr(fem_calculix, "uav_wing", lambda refinement: wing)
    monkeypatch.setattr(
        fem_calculix,
        "calculix",
        lambda _wing, state, _lattice, large: wing.strain_microstrain(state, 3.0) * (0.99 if large else 1.0),
    )
    line = fem_calculix.bent({}, 0.25)
    assert line["change_least"] == pytest.approx(-1.0)
    assert line["usable_most"] < 1.0


def test_calculix_lines_say_where_it_is_absent(monkeypatch):
    monkeypatch.setattr(shutil, "which", lambda name: None)
    lines = list(fem_calculix.results(1.0, [1]))
    assert fem_calculix.summary(lines) == "skipped: CalculiX (ccx) is not installed"


def test_dataset_lines_count_rows_and_memory():
    lines = [fem_dataset.streamed(model, 20, 3, 1, 0.25) for model in ("full wing", "reduced wing")]
    assert [line["rows"] for line in lines] == [60, 60]
    assert lines[0]["peak_megabytes"] > 50
    assert "| reduced wing, 20 states x 3 readings | 60 | 1 |" in fem_dataset.summary(lines)


@pytest.mark.skipif(not fem_calibration.FOLDER.exists(), reason="the published data are not beside the project")
def test_calibration_lines_make_tables_and_a_picture(tmp_path):
    wing = uav_wing(refinement=0.3)
    ours = fem_calibration.simulated_strains(wing)
    theirs = fem_calibration.published_strains(fem_calibration.FOLDER / "strains.csv")
    lines = [*fem_calibration.gauges(ours, theirs), *fem_calibration.distances(ours, theirs)]
    lines += [fem_calibration.tip(wing), *fem_calibration.frequencies(wing)]
    table = fem_calibration.summary(lines)
    assert "| tip stiffness [N/mm] | measured 0.682; published 0.677;" in table
    assert "| g24 (left out) |" in table
    fem_calibration.picture(lines, tmp_path / "residuals.png")
    assert (tmp_path / "residuals.png").stat().st_size > 10_000
