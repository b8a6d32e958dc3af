"""Doors to other people's models: function, table and program, and the functions of the page that ask others."""

import json
import multiprocessing
import sys
import threading
from pathlib import Path

import numpy as np
import pytest

from octmip.errors import DataError, TwinError
from octmip.gap import CachedTwin, Differences, Odds, Recorded, diagnose, function_twin, gathered
from octmip.gap.doors import Card, open_twin, read_card, table_twin
from octmip.interfaces.report.diagnosis.recommendation import recommend
from octmip.twin import Effect, Loads, Twin

DOORS = Path(__file__).parents[2] / "docs" / "howto" / "doors.md"
READINGS = {"tip": "mm", "mid": "mm", "f1": "Hz"}
RANGES = {"stiffness": (100.0, 80.0, 120.0, "N/mm"), "gap": (0.0, 0.0, 0.5, "mm")}
CARD = {"readings": READINGS, "loads": ["force"], "parameters": RANGES}
SOURCE = """
import math

def beam(parameters, loads):
    k, gap = parameters["stiffness"], parameters["gap"]
    tip = loads["force"] / k + gap * math.tanh(loads["force"] / 20.0)
    return {"tip": tip, "mid": 0.31 * loads["force"] / k + 0.5 * gap * math.tanh(loads["force"] / 20.0),
            "f1": 12.0 * math.sqrt(k / 100.0)}
"""
space: dict = {}
exec(SOURCE, space)
beam = space["beam"]
TWIN = function_twin(beam, READINGS, RANGES, loads=("force",))


def measured(seed=0, stiffness=100.0, gap=0.0, loads=(50.0, 100.0, 200.0), repeats=12):
    rng, force = np.random.default_rng(seed), np.repeat(loads, repeats)
    clean = [list(beam({"stiffness": stiffness, "gap": gap}, {"force": f}).values()) for f in force]
    readings = np.array(clean) + rng.standard_normal((len(force), 3)) * [0.01, 0.004, 0.02]
    return gathered(TWIN, [Recorded(row, {"force": f}) for f, row in zip(force, readings, strict=True)])


def found_in(twin, **truth):
    return diagnose(measured(**truth), twin, odds=Odds(differences=Differences(constants=0.01)))


def test_every_parameter_with_a_range_is_an_effect():
    assert isinstance(TWIN, Twin)
    assert all(isinstance(effect, Effect) for effect in TWIN.effects.values())
    stiffness, gap = TWIN.effects["stiffness"], TWIN.effects["gap"]
    assert (stiffness.bounds, stiffness.is_one_sided, stiffness.unit) == ((-20.0, 20.0), False, "N/mm")
    assert (gap.bounds, gap.is_one_sided) == ((0.0, 0.5), True)
    assert (stiffness.prior_sd, gap.prior_sd) == (10.0, 0.25)
    assert stiffness.signature(TWIN, {}, 100.0)[0] == pytest.approx(-100.0 / 100.0**2, rel=0.01)
    exact = stiffness.predict(TWIN, {}, 100.0, 15.0, "", 0.0)
    assert exact == pytest.approx(list(beam({"stiffness": 115.0, "gap": 0.0}, {"force": 100.0}).values()))


@pytest.mark.parametrize(
    ("truth", "size"), [({"stiffness": 88.0}, -12.0), ({"stiffness": 114.0}, 14.0), ({"gap": 0.2}, 0.2)]
)
def test_a_parameter_that_is_not_nominal_is_found_with_its_size(truth, size):
    (name,) = truth
    diagnosis = found_in(TWIN, **truth)
    (found,) = diagnosis.which[0].parameters
    assert found.effect == name
    assert found.size == pytest.approx(size, rel=0.08)
    assert recommend(diagnosis).startswith(f"Correct the {name}: it is ")


def test_a_reading_that_is_zero_in_the_model_spoils_no_diagnosis():
    twin = function_twin(
        lambda p, loads: [p["k"] * loads["f"], 0.0], {"a": "mm", "b": "deg"}, {"k": (1, 0.8, 1.2)}, ("f",)
    )
    rng = np.random.default_rng(1)
    rows = [Recorded(rng.normal([force, 0.0], 0.01), {"f": force}) for force in np.repeat([1.0, 2.0], 8)]
    assert recommend(diagnose(gathered(twin, rows), twin)).startswith("Nothing to do: ")


def test_a_parameter_whose_nominal_value_is_the_greatest_falls():
    twin = function_twin(
        lambda p, loads: [p["efficiency"] * loads["power"]], {"out": "W"}, {"efficiency": (1.0, 0.6, 1.0)}, ("power",)
    )
    falls = twin.effects["efficiency"]
    assert (falls.bounds, falls.is_one_sided) == ((0.0, 0.4), True)
    assert falls.signature(twin, {}, 10.0) == pytest.approx([-10.0])
    assert falls.says[0] == "it is {size} below the model's 1"


def test_states_of_a_function_are_given_test_by_test():
    twin = function_twin(lambda p, _: [10 * p["crack"] + p["k"]], {"u": "mm"}, {"k": (1, 0, 2)}, (), states=("crack",))
    assert twin.parameters == ("crack",)
    assert CachedTwin(twin).predict({"crack": 0.2}, Loads((), ())) == pytest.approx([3.0])


def test_more_effects_keep_those_that_were_added_before_and_the_answers():
    asked = []

    def line(parameters, loads):
        asked.append(parameters)
        return [parameters["k"] * loads["force"]]

    twin = function_twin(line, {"u": "mm"}, {"k": (1.0, 0.5, 2.0)}, ("force",))
    twin.predict({}, 3.0)
    drift, gain = (TWIN.effects[name] for name in ("stiffness", "gap"))
    both = twin.with_effects(drift).with_effects(gain)
    assert list(both.effects) == ["k", "stiffness", "gap"]
    assert list(twin.effects) == ["k"]
    assert both.predict({}, 3.0) == pytest.approx([3.0])
    assert both.effects["k"].predict(both, {}, 3.0, 0.5, "", 0.0) == pytest.approx([4.5])
    twin.ask({}, 3.0, {"k": 1.5})
    assert len(asked) == 2


@pytest.mark.parametrize(
    ("given", "told"),
    [
        ({"readings": {}}, "names no reading"),
        ({"readings": {"u": "mm"}, "loads": ("u",)}, "names 'u' twice"),
        ({"readings": {"u": "mm"}, "parameters": {"k": (1, 2)}}, "expected nominal, low, high"),
        ({"readings": {"u": "mm"}, "parameters": {"k": (5, 0, 2)}}, "'k'.*low <= nominal <= high"),
        ({"readings": {"u": "mm"}, "channels": {"v": "laser"}}, "channel to 'v'"),
    ],
)
def test_a_card_that_makes_no_sense_is_refused(given, told):
    with pytest.raises(DataError, match=told):
        Card(**given)


def beside(path, card=CARD):
    (path.parent / f"{path.name}.json").write_text(json.dumps(card))
    return path


def table(tmp_path, steps=40, name="beam.csv", scatter=None):
    axes = [np.linspace(80, 120, steps + 1), np.linspace(0, 0.5, 6), [0.0, 50.0, 100.0, 200.0]]
    points = np.array(np.meshgrid(*axes, indexing="ij")).reshape(3, -1).T
    points = points if scatter is None else np.delete(points, scatter, axis=0)
    rows = [[*p, *beam({"stiffness": p[0], "gap": p[1]}, {"force": p[2]}).values()] for p in points.tolist()]
    lines = [",".join(["stiffness", "gap", "force", *READINGS]), *(",".join(f"{v:.17g}" for v in row) for row in rows)]
    path = tmp_path / name
    path.write_text("\n".join(lines))
    return beside(path)


def test_a_table_is_exact_at_its_rows_and_diagnosed_as_the_function_to_its_interpolation_error(tmp_path):
    twin = table_twin(table(tmp_path))
    assert twin.predict({}, 200.0) == pytest.approx(TWIN.predict({}, 200.0), rel=1e-14)
    between = twin.effects["stiffness"].predict(twin, {}, 200.0, 0.5, "", 0.0)
    true = TWIN.effects["stiffness"].predict(TWIN, {}, 200.0, 0.5, "", 0.0)
    spacing, curvature = 1.0, 2 * 200.0 / 100.0**3
    assert np.abs(between - true).max() < curvature * spacing**2 / 8 + 1e-12
    own, exact = (found_in(t, stiffness=118.0).which[0].parameters[0] for t in (twin, TWIN))
    assert own.effect == exact.effect
    assert own.size == pytest.approx(exact.size, rel=2e-3)


def test_a_table_that_is_no_grid_is_triangulated(tmp_path):
    twin = table_twin(table(tmp_path, steps=4, scatter=[17, 90]))
    assert twin.predict({}, 150.0) == pytest.approx(TWIN.predict({}, 150.0), rel=0.02)


def test_a_table_extrapolates_nothing(tmp_path):
    twin = table_twin(table(tmp_path))
    with pytest.raises(TwinError, match=r"force 210; it holds 0 to 200, and nothing is extrapolated"):
        twin.predict({}, 210.0)


@pytest.mark.parametrize(
    ("change", "told"),
    [
        (lambda text: text.replace("tip", "top", 1), "tip"),
        (lambda text: text.replace("80,0,0,0,", "80,0,0,low,", 1), "line 2, column 'tip': 'low' is no number"),
        (lambda text: text + '\n"1,2', "beam.csv"),
    ],
)
def test_a_table_that_does_not_hold_its_card_is_refused(tmp_path, change, told):
    path = table(tmp_path)
    path.write_text(change(path.read_text()))
    with pytest.raises(DataError, match=told):
        table_twin(path)


def of_page(name):
    """Return a function that the how-to page of the doors prints."""
    space = {}
    for block in DOORS.read_text().split("```python\n")[1:]:
        code = block.partition("```")[0]
        if f"def {name}(" in code or "def within(" in code:
            exec(code, space)
    return space[name]


def test_a_question_that_is_never_answered_ends_in_time():
    within = of_page("within")
    assert within(5, abs, -3) == 3
    with pytest.raises(multiprocessing.TimeoutError):
        within(0.1, threading.Event().wait, 60)


def test_the_command_opens_every_door_by_one_word(tmp_path, monkeypatch):
    monkeypatch.syspath_prepend(tmp_path)
    (tmp_path / "towers.py").write_text(SOURCE)
    card = str(tmp_path / "beam.csv.json")
    for name, given in (
        (f"table:{table(tmp_path)}", None),
        (f"table:{tmp_path / 'beam.csv'}", card),
        ("python:towers:beam", card),
        ("towers:beam", card),
    ):
        assert open_twin(name, given).predict({}, 100.0) == pytest.approx(TWIN.predict({}, 100.0), rel=1e-12), name
    (tmp_path / "beam.csv.json").unlink()
    with pytest.raises(DataError, match=r"beam.csv.json"):
        open_twin(f"table:{tmp_path / 'beam.csv'}")


@pytest.mark.parametrize(
    ("rows", "told"),
    [
        (["1,0,2", "1,0,3"], "rows 2 and 3 hold the same a 1, b 0; expected one row for each"),
        (["1,0,2", "1,1,3", "1,0,4"], "rows 2 and 4 hold the same a 1, b 0; expected one row for each"),
        (["0,0,1", "1,1,2", "2,2,3"], "3 rows that span no area in a, b"),
    ],
)
def test_rows_that_cannot_be_interpolated_are_refused(tmp_path, rows, told):
    path = tmp_path / "plane.csv"
    path.write_text("\n".join(["a,b,u", *rows]))
    beside(path, {"readings": {"u": "mm"}, "loads": ["a", "b"]})
    with pytest.raises(DataError, match=told):
        table_twin(path)


@pytest.mark.parametrize(
    ("name", "told"),
    [
        ("nodoor:beam", r"'nodoor' cannot be imported .*expected MODULE:NAME, or a door such as table:"),
        ("json:dumps", r"'json:dumps' cannot be called without arguments.*function"),
        ("python:json:dumps", r"'json:dumps' cannot be called .*f\(parameters, loads\).*--card CARD.json"),
        ("pickletools:dis", "pickletools"),  # the library's own, which makes no twin
        ("table:beam.csv", r"^table beam.csv is not there; expected a CSV or Parquet file"),
        ("table:here.csv", r"^card here.csv.json is not there: .*--card"),
    ],
)
def test_what_opens_no_door_is_one_sentence_with_its_cure_and_a_file_beside_it_hides_no_package(
    tmp_path, monkeypatch, name, told
):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "path", [path for path in sys.path if path])
    monkeypatch.delitem(sys.modules, "pickletools", raising=False)
    (tmp_path / "pickletools.py").write_text("raise SystemExit")
    (tmp_path / "here.csv").write_text("force,tip\n1,2\n")
    with pytest.raises(DataError, match=told):
        open_twin(name)


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("{", "line 1, column 2: Expecting property name"),
        ("[]", "holds a JSON list; expected one object"),
        ("{}", "no object 'readings'"),
        ('{"readings": {"u": 1}}', r"card.json: readings.u is 1; expected a text"),
        ('{"readings": {"u": "mm"}, "loads": [[]]}', r"loads\[0\] is \[\]; expected a text"),
        ('{"readings": {"u": "mm"}, "load": []}', "has the key 'load'"),
    ],
)
def test_a_card_file_that_is_none_is_refused(tmp_path, text, told):
    (tmp_path / "card.json").write_text(text)
    with pytest.raises(DataError, match=told):
        read_card(tmp_path / "card.json")
