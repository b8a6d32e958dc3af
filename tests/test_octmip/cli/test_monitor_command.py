"""From a stranger's model to C by one command: `octmip monitor`."""

import ctypes
import json
import re
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest

from octmip.errors import ProblemError
from octmip.gap import function_twin
from octmip.interfaces.cli import main
from octmip.monitor import ModelSelector
from octmip.sensing.monitor_design import design_monitor
from octmip.trees.prediction import predict

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
    answers = [level((ctypes.c_double * 4)(*row)) for row in readings.tolist()]
    assert answers == selector.select_many(readings, {"truck_1": 20.0, "truck_2": 30.0}).tolist()


def test_each_load_has_a_folder_and_json_says_what_holds(capsys):
    said(*LOAD, "--load", "truck_1=20,truck_2=0", *NOISE, "--json")
    first, second = json.loads(capsys.readouterr().out)["monitors"]
    assert (first["folder"], second["folder"]) == ("out/load-1", "out/load-2")
    assert first["holds_for"] == "this load"
    (crack,) = first["states"]
    assert crack["levels"] == pytest.approx([0.0, 0.1, 0.2, 0.3, 0.4])
    assert crack["off_by_on_fresh_readings"] < 0.5 * crack["off_by_without_readings"]


@pytest.mark.parametrize(
    ("words", "told"),
    [
        ((*LOAD, "--noise", "m=1"), r"--noise names 'm'; expected a unit among .*'mm'.* or a reading among"),
        ((*LOAD, "--noise", "mm=1"), r"--noise says nothing of 'e' \[microstrain\]; give microstrain=SD"),
        (("--load", "truck=1", *NOISE), r"expected the twin's loads \['truck_1', 'truck_2'\] by name"),
        ((*LOAD, *NOISE, "--states", "crak=0,1"), r"levels names 'crak'; expected among \['crack'\]"),
        ((*LOAD, *NOISE, "--states", "crack"), r"--states is 'crack'; expected NAME=LEVEL,..."),
        ((*LOAD, *NOISE, "--cost", "w9=2"), r"costs names 'w9'; expected among"),
        ((*LOAD, "--noise", "much"), r"--noise holds 'much'; expected a number"),
    ],
)
def test_wrong_words_are_one_sentence(words, told, capsys):
    assert said(*words) == 2
    assert re.search(told, capsys.readouterr().err)


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


def test_what_a_tree_is_off_is_counted_on_fresh_readings():
    design = design_monitor(TWO, {}, 0.3, n_draws=12)
    told = np.array(design.trees[0].values)[predict(design.trees[0].tree, design.fresh)]
    assert design.off_by[0] == pytest.approx(np.abs(told - design.library.states[design.truth, 0]).mean())
    assert not np.isin(design.fresh[:, 0], design.problems[0].features[:, 0]).any()


def test_a_twin_without_a_state_cannot_be_monitored():
    with pytest.raises(ProblemError, match="no state parameter, so there is nothing to monitor"):
        design_monitor(function_twin(lambda p, loads: [1.0], {"a": "mm"}), 1.0, 0.1)
