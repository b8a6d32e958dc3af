"""What programs of simulation and measurement write beside numbers: prints, columns of units, midnights, probes."""

import json
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import femlib
from octmip.errors import DataError
from octmip.gap import function_twin, read_campaign
from octmip.recordings import recording

BEAM = """
import subprocess
print("a licence was taken")
def beam(parameters, loads):
    print("iteration 1")
    subprocess.run(["echo", "iteration 2"])
    return {"tip": loads["force"] / parameters["stiffness"]}
"""
CARD = {"readings": {"tip": "mm"}, "loads": ["force"], "parameters": {"stiffness": [100, 70, 130, "N/mm"]}}
TWIN = function_twin(lambda own, loads: {"tip": loads["force"] / 100.0}, {"tip": "mm"}, loads=["force"])


def campaign(folder: Path, header: str, rows: list[str]) -> Path:
    (folder / "run.csv").write_text("\n".join([header, *rows]) + "\n")
    return folder / "run.csv"


def printed(folder: Path, *words: str) -> tuple[dict[str, Any], str]:
    """Return the object on standard output of a command beside a model that prints, and what is on standard error."""
    (folder / "printing.py").write_text(BEAM)
    (folder / "card.json").write_text(json.dumps(CARD | {"states": ["crack"], "state_limits": {"crack": 0.8}}))
    twin = ("--twin", "python:printing:beam", "--card", "card.json", "--json")
    done = subprocess.run(
        [sys.executable, "-m", "octmip.interfaces.cli", *words, *twin], cwd=folder, capture_output=True, text=True
    )
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout), done.stderr


def test_what_a_model_and_its_programs_print_stands_beside_the_answer(tmp_path):
    rows = [f"pull,{force},{force / 100 + 0.001 * (k - 1)}" for force in (0, 25, 50) for k in range(3)]
    campaign(tmp_path, "test,force,tip", rows)
    answer, said = printed(tmp_path, "diagnose", "run.csv")
    assert answer["verdict"]
    assert [line in said for line in ("a licence was taken", "iteration 1", "iteration 2")] == [True] * 3
    answer, said = printed(tmp_path, "monitor", "--load", "force=20", "--noise", "0.01", "--out", "made")
    assert (len(answer["monitors"]), "a licence was taken" in said) == (1, True)


@pytest.mark.parametrize("shape", [(2,), (1, 2), (2, 1)])
def test_a_model_answers_a_row_or_a_column(shape):
    twin = function_twin(lambda own, loads: np.array([3.0, 4.0]).reshape(shape), {"a": "mm", "b": "Hz"})
    assert twin.predict({}, 1.0).tolist() == [3.0, 4.0]


@pytest.mark.parametrize("name", ["tip_unit", "tip unit", "tip.Units"])
def test_a_column_that_says_the_unit_of_another_is_heeded(name, tmp_path):
    path = campaign(tmp_path, f"test,force,tip,{name}", [f"a,{force},{10 * force},um" for force in (1, 2, 3)])
    read = read_campaign(path, TWIN)
    np.testing.assert_allclose(read.readings[:, 0], [0.01, 0.02, 0.03])
    assert read.notes == ("Column tip was converted from um to mm.",)


def test_a_column_of_two_units_is_refused(tmp_path):
    path = campaign(tmp_path, "test,force,tip,tip_unit", ["a,1,10,um", "a,2,0.02,mm"])
    with pytest.raises(DataError, match="'tip_unit' holds the units 'mm', 'um'; expected one in every row; convert"):
        read_campaign(path, TWIN)


CLOCKS = {
    "23:59:58,23:59:59,,0:00:00,0:00:01": [86398.0, 86399.0, np.nan, 86400.0, 86401.0],
    "23:00,11:00,10:00": [82800.0, 39600.0, 36000.0],
    "10:00,23:00,1:00,13:00,0:30": [36000.0, 82800.0, 90000.0, 133200.0, 174600.0],
}
"""Times of day in the order of rows; those that fall elsewhere too are in no order of time."""


@pytest.mark.parametrize("clock", CLOCKS)
def test_times_of_day_go_on_past_midnight(clock, tmp_path):
    path = campaign(tmp_path, "time,test,force,tip", [f"{at},a,1,0.01" for at in clock.split(",")])
    read = read_campaign(path, TWIN)
    np.testing.assert_allclose(read.time, CLOCKS[clock])
    assert any("midnight" in note for note in read.notes) == (max(CLOCKS[clock][-1:]) > 86400.0)


@pytest.mark.parametrize("head", ["#       Probe             0             1\n#        Time\n", "# Time  0  1\n"])
def test_probes_of_openfoam_are_counted_in_a_comment(head, tmp_path):
    rows = "".join(f"{0.1 * k:>13g}{1.5 * k:>14g}{2.5 * k:>14g}\n" for k in range(9))
    (tmp_path / "p.dat").write_text(f"# Probe 0 (0 0 0)\n# Probe 1 (0.5 0 0)\n{head}{rows}")
    (tmp_path / "p.dat").rename(tmp_path / "p.csv")
    run = recording(tmp_path / "p.csv")
    assert run.channels == ("0", "1")
    np.testing.assert_allclose(run["1"].values, 25.0 * run["1"].time)


MESH = """$MeshFormat
2.2 0 8
$EndMeshFormat
$Nodes
4
1 0 0 0
2 1 0 0
3 1 1 0
4 0 1 0
$EndNodes
$Elements
1
1 3 2 1 1 1 2 3 4
$EndElements
$NodeData
1
"u"
1
0.0
3
0
1
2
1 0.5
2 0.6
$EndNodeData
"""


def test_results_at_some_nodes_are_no_part_of_a_mesh_of_gmsh(tmp_path):
    pytest.importorskip("meshio")
    (tmp_path / "a.msh").write_text(MESH)
    mesh = femlib.read(tmp_path / "a.msh")
    assert (len(mesh.nodes), len(mesh.quads)) == (4, 1)
