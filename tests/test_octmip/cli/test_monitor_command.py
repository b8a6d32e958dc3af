"""From a stranger's model to C by one command: `octmip monitor`."""

import ctypes
import json
import re
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from octmip.errors import ProblemError
from octmip.formats.tree_file import read_tree_file
from octmip.gap import function_twin
from octmip.interfaces.cli import main
from octmip.monitor import ModelSelector
from octmip.sensing.monitor_design import design_monitor

BRIDGE = """
import numpy as np

def bridge(parameters, loads):
    soft = np.array([1.0, 2.0, 1.5]) / parameters["stiffness"] * (1.0 + parameters["crack"] * np.array([0.2, 2.0, 0.6]))
    bearing = loads["truck_1"] / parameters["left"] + loads["truck_2"] / parameters["right"]
    down = loads["truck_1"] * soft + 0.7 * loads["truck_2"] * soft[::-1] + bearing
    return [*down, parameters["arm"] * loads["truck_2"]]
"""
CARD = {
    "readings": {"w1": "mm", "w2": "mm", "w3": "mm", "e": "microstrain"},
    "loads": ["truck_1", "truck_2"],
    "states": ["crack"],
    "state_limits": {"crack": 0.5},
    "parameters": {"stiffness": [20, 14, 26], "left": [50, 20, 80], "right": [50, 20, 80], "arm": [1, 0.5, 2]},
}
WORDS = ["monitor", "--twin", "python:their_bridge:bridge", "--card", "card.json", "--out", "out"]
LOAD = ["--load", "truck_1=20,truck_2=30"]
NOISE = ["--noise", "mm=0.05", "--noise", "microstrain=1"]


@pytest.fixture(autouse=True)
def bridge(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(tmp_path)
    Path("their_bridge.py").write_text(BRIDGE)
    Path("card.json").write_text(json.dumps(CARD))


def said(*words):
    return main([*WORDS, *words])


def test_a_bridge_goes_from_nothing_to_c_by_one_command(capsys):
    said(*LOAD, *NOISE, "--linear", "--budget", "1")
    shown = capsys.readouterr().out
    assert "out: read w2 at truck_1 20, truck_2 30; the trees hold for every multiple of this load" in shown
    assert {path.name for path in Path("out").iterdir()} == {"crack.json", "crack.html", "crack.c", "monitor.json"}
    selector = ModelSelector.read("out/monitor.json")
    readings = 3.0 * selector.library.strains
    states = selector.select_many(readings, {"truck_1": 60.0, "truck_2": 90.0})
    assert np.abs(selector.library.states[states, 0] - selector.library.states[:, 0]).max() <= 0.1 + 1e-12


@pytest.mark.skipif(shutil.which("cc") is None, reason="needs a C compiler")
def test_the_c_function_answers_as_the_tree_does():
    said(*LOAD, *NOISE)
    subprocess.run(["cc", "-shared", "-fPIC", "-Wall", "-Werror", "-o", "crack.so", "out/crack.c"], check=True)
    level = ctypes.CDLL("./crack.so").crack_level
    selector = ModelSelector.read("out/monitor.json")
    readings = selector.library.strains + np.random.default_rng(1).normal(0.0, 0.5, (5, 4))
    level.restype = ctypes.c_double
    answers = [level((ctypes.c_double * 4)(*row)) for row in readings.tolist()]
    states = selector.select_many(readings, {"truck_1": 20.0, "truck_2": 30.0})
    assert answers == selector.library.states[states, 0].tolist()


@pytest.mark.parametrize(
    ("words", "told"),
    [
        ((*LOAD, "--noise", "m=1"), r"--noise names 'm'; expected a unit among .*'mm'.* or a reading among"),
        ((*LOAD, "--noise", "mm=1"), r"--noise says nothing of 'e' \[microstrain\]; give microstrain=SD"),
        ((*LOAD, *NOISE, "--states", "crack"), r"--states is 'crack'; expected NAME=LEVEL,..."),
        ((*LOAD, "--noise", "much"), r"--noise holds 'much'; expected a number"),
        (("--readings", "x.csv"), "--readings is given without --deployed"),
        (("--inspected", "three", "--noise", "1"), "--inspected is given without --readings"),
        (("--readings", "x.csv", "--deployed", "old", "--noise", "1"), "--noise stands beside --deployed"),
        (("--readings", "x.csv", "--deployed", "old"), "--deployed old has no monitor.json; expected a folder"),
        (("--readings", "x.csv", "--deployed", "out"), "--out out is the deployed folder"),
        ((), "--noise is missing"),
        (("--noise", "1", "--only", "one,four"), r"the twin has no state 'one'; expected among \['crack'\]"),
    ],
)
def test_wrong_words_are_one_sentence(words, told, capsys):
    Path("x.csv").write_text("test\n")
    assert said(*words) == 2
    assert re.search(told, capsys.readouterr().err)
    assert not Path("out").exists()


def two_damages(parameters, loads):
    one, two = parameters["one"], parameters["two"]
    return [10.0 * one + 4.0 * two, 4.0 * one + 10.0 * two, 8.0 * (one + two), 12.0 * one]


TWO = function_twin(two_damages, dict.fromkeys(("a", "b", "c", "d"), "mm"), loads=(), states=("one", "two"))


def test_trees_of_several_states_share_the_sensors_of_a_budget():
    free = design_monitor(TWO, {}, 0.3, n_draws=12)
    bound = design_monitor(TWO, {}, 0.3, n_draws=12, budget=1.0)
    dear = design_monitor(TWO, {}, 0.3, n_draws=12, budget=1.0, costs=dict.fromkeys(bound.sensors, 2.0))
    assert len(free.sensors) > 1
    assert len(bound.sensors) == 1
    assert not set(bound.sensors) & set(dear.sensors)
    assert sum(free.off_by) < sum(bound.off_by)


PLATE = """
import numpy as np
from octmip.gap import function_twin

def plate(parameters, loads):
    at = np.linspace(0.0, 1.0, 9)
    near = lambda place: np.exp(-(((at - place) / 0.12) ** 2))
    damaged = 300 * parameters["one"] * near(0.2) + 60 * parameters["two"] * near(0.8)
    return loads["load_factor"] * (900 - 500 * at + damaged + 200 * parameters["three"] * near(0.5))

gauges = {f"g{k}": "microstrain" for k in range(1, 10)}
twin = function_twin(plate, gauges, loads=["load_factor"], states=("one", "two", "three"), linear=True)
"""
AGAIN = ["monitor", "--twin", "their_plate:twin", "--deployed", "old", "--out", "new", "--readings"]


@pytest.fixture
def plate(monkeypatch):
    """A plate that is monitored for two of its three damages; what writes 40 readings of it."""
    Path("their_plate.py").write_text(PLATE)
    words = ["--only", "one,two", "--load", "load_factor=3", "--noise", "30", "--draws", "12", "--out", "old"]
    assert main(["monitor", "--twin", "their_plate:twin", *words]) == 0
    monkeypatch.delitem(sys.modules, "their_plate", raising=False)
    rng, gauges = np.random.default_rng(2), [f"g{k}" for k in range(1, 10)]

    def fly(path, change):
        at, rows = np.linspace(0.0, 1.0, 9), []
        for k in range(40):
            one, three = 0.01 * k, change(k)[0]
            strain = 900 - 500 * at + 300 * one * np.exp(-(((at - 0.2) / 0.12) ** 2))
            strain = strain + 200 * three * np.exp(-(((at - 0.5) / 0.12) ** 2))
            rows.append(3 * strain + rng.normal(0.0, 30.0, 9) + change(k)[1])
        table = pd.DataFrame(rows, columns=gauges)
        table.insert(0, "load_factor", 3.0)
        table.insert(0, "test", "flight")
        table.to_csv(path, index=False)

    return fly


def test_the_loop_goes_from_an_alarm_to_a_proven_tree_that_reads_the_damage(plate, capsys):
    plate("flight.csv", lambda k: (0.6 * (k >= 15), 0.0))
    capsys.readouterr()
    assert main([*AGAIN, "flight.csv", "--draws", "12"]) == 0
    shown = capsys.readouterr().out
    size = re.search(r"most likely damage at three \(100 %\), (\d+) \+- \d+ %", shown)
    assert size
    assert 50 <= int(size[1]) <= 70
    change = json.loads(Path("new/change.json").read_text())
    assert 16 <= change["watch"]["alarm"] <= 18  # the sixteenth reading is the first of the damage
    assert (change["added"], change["states_before"], change["states"]) == ("three", 25, 125)
    one, two, three = change["trees"]
    assert (one["change"], three["change"]) == ("kept", "new")
    assert one["sha256"] == one["sha256_deployed"] != three["sha256"]  # of the tree alone: the data are others
    assert read_tree_file("new/one.json").tree == read_tree_file("old/one.json").tree
    assert two["change"] == "kept"
    assert three["is_optimal"]
    assert max(change["told_since"], key=change["told_since"].get) in ("0.4", "0.6", "0.8")
    assert change["alarm_of_enriched_library"] is None
    assert "three is now in the library" in Path("new/change.html").read_text()


def test_a_faulty_gauge_or_a_state_of_the_library_changes_no_tree(plate, capsys):
    plate("sound.csv", lambda k: (0.0, 0.0))
    plate("faulty.csv", lambda k: (0.0, 400.0 * (np.arange(9) == 6) * (k >= 20)))
    Path("sound.csv").write_text(Path("sound.csv").read_text().replace("g1,g2", "h1 [mm],g2"))
    assert main([*AGAIN, "sound.csv"]) == 0
    told = capsys.readouterr().out
    assert "no alarm in 40 readings" in told
    assert "note: Column 'h1 [mm]': the twin has no such reading; not used." in told
    assert "marginalises" not in told
    assert main([*AGAIN, "faulty.csv"]) == 0
    told = capsys.readouterr().out
    assert "gauge g7 is left out: it is faulty, or damage is at it alone" in told
    assert "the library explains the other gauges" in told
    assert not Path("new").exists()


def test_what_is_wrong_is_said_before_trees_are_trained(plate, capsys):
    plate("flight.csv", lambda k: (0.6 * (k >= 15), 0.0))
    table = pd.read_csv("flight.csv")
    table.loc[5, "load_factor"] = 0.0
    table.to_csv("unloaded.csv", index=False)
    capsys.readouterr()
    assert main([*AGAIN, "unloaded.csv"]) == 2
    assert "unloaded.csv, row 7: load_factor is 0.0" in capsys.readouterr().err
    assert main([*AGAIN, "flight.csv", "--out", "flight.csv"]) == 1
    assert "folder 'flight.csv' cannot be made" in capsys.readouterr().err
    before = sorted(Path().iterdir())
    assert main([*AGAIN, "flight.csv", "--draws", "0"]) == 2
    assert "n_draws is 0; expected" in capsys.readouterr().err
    assert sorted(Path().iterdir()) == before  # no folder, and none that is half filled
    shutil.copy("old/one.json", "old/two.json")
    assert main([*AGAIN, "flight.csv"]) == 2
    assert "two.json is a tree of 'one'; expected one of 'two'" in capsys.readouterr().err


def test_a_twin_without_a_state_cannot_be_monitored():
    with pytest.raises(ProblemError, match="no state parameter, so there is nothing to monitor"):
        design_monitor(function_twin(lambda p, loads: [1.0], {"a": "mm"}), 1.0, 0.1)
