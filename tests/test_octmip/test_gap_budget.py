"""A model that costs seconds an answer: a stated number of questions, answers on disk, failures named."""

import json
import sys
from pathlib import Path

import numpy as np
import pytest

from octmip.errors import DataError, TwinError
from octmip.gap import Budget, diagnose, function_twin
from octmip.gap.doors import Range
from octmip.interfaces.cli import main
from tests.test_octmip.test_gap_built import RANGES, READINGS, SPRINGS, read, springs, under


def counted(fails=lambda p, loads: False):
    """Return a twin of the springs and the questions that it was asked."""
    asked = []

    def model(p, loads):
        asked.append((dict(p), dict(loads)))
        if fails(p, loads):
            raise RuntimeError("no convergence")
        return springs(p, loads)

    return function_twin(model, READINGS, RANGES, loads=("force",)), asked


@pytest.mark.parametrize("calls", [15, 17, 21, 24, 60])
@pytest.mark.parametrize("built", [10.0, 9.4])
def test_a_change_is_named_within_a_budget_of_questions(calls, built):
    twin, asked = counted()
    told = []
    budget = Budget(calls, progress=lambda done, total: told.append((done, total)))
    run, now = read(SPRINGS, under(), 2, k1=built), read(SPRINGS, under(), 1, k1=built, k2=10.2)
    found = diagnose(now, twin, commissioning=run, budget=budget)
    assert len(asked) <= calls
    assert found.which[0].effects == ("k2",)
    size = found.which[0].parameters[0]
    assert size.size == pytest.approx(-1.8, abs=0.35 if calls > 20 else 0.7)  # slopes alone, then curvature
    assert [done for done, _ in told] == list(range(1, len(asked) + 1))
    assert all(done <= total for done, total in told)
    assert any(f"answered {len(asked)} questions (budget {calls})" in note for note in found.notes)


def test_a_budget_that_does_not_reach_is_refused_with_the_least_that_does():
    twin, asked = counted()
    with pytest.raises(DataError, match="the budget is 14 calls of the model; expected 15 or more"):
        diagnose(read(SPRINGS, under(), 1), twin, budget=Budget(14))
    assert not asked
    with pytest.raises(DataError, match="the budget is 0 calls"):
        Budget(0)


def test_answers_on_disk_are_not_asked_for_again_whatever_was_cut_off(tmp_path):
    file, now = tmp_path / "answers.jsonl", read(SPRINGS, under(), 1, k1=8.5)
    first, asked = counted()
    whole = diagnose(now, first, budget=Budget(30, answers=file))
    lines = file.read_text().splitlines()
    assert len(lines) == 1 + len(asked)
    file.write_text("\n".join(lines[:10]) + '\n{"asked": [10.0')
    second, again = counted()
    found = diagnose(now, second, budget=Budget(30, answers=file))
    assert len(again) == len(asked) - 9 + 1  # one is asked again, to see that the model is the same
    assert [one.mean for one in found.constants] == pytest.approx([one.mean for one in whole.constants])
    third, none = counted()
    diagnose(now, third, budget=Budget(30, answers=file))
    assert len(none) == 1
    softer = function_twin(lambda p, loads: 2.0 * np.array(springs(p, loads)), READINGS, RANGES, loads=("force",))
    with pytest.raises(DataError, match="holds answers of another model"):
        diagnose(now, softer, budget=Budget(30, answers=file))
    other = function_twin(springs, READINGS, RANGES | {"more": (1.0, 0.5, 2.0)}, loads=("force",))
    with pytest.raises(DataError, match=r"answers\.jsonl holds no answers of this model"):
        diagnose(now, other, budget=Budget(60, answers=file))
    assert json.loads(file.read_text().splitlines()[0])["readings"] == list(READINGS)


@pytest.mark.parametrize("budget", [None, Budget(60), Budget(60, jobs=2)])
@pytest.mark.parametrize("with_run", [False, True])
@pytest.mark.parametrize("answer", ["no convergence", float("nan")])
def test_a_parameter_at_whose_values_the_model_fails_is_left_out_and_named(budget, with_run, answer):
    def model(p, loads):
        if abs(p["k2"] - 12.0) > 0.01 and answer == "no convergence":
            raise RuntimeError(answer)
        return [value if abs(p["k2"] - 12.0) < 0.01 else answer for value in springs(p, loads)]

    twin = function_twin(model, READINGS, RANGES, loads=("force",))
    run = read(SPRINGS, under(), 2) if with_run else None
    found = diagnose(read(SPRINGS, under(), 1, k1=8.0), twin, commissioning=run, budget=budget)
    assert any(note.startswith("The parameter k2 is left out") and str(answer) in note for note in found.notes)
    assert "k2" not in found.inclusion
    if with_run:
        assert found.which[0].effects == ("k1",)
    else:
        assert {one.name for one in found.constants} == {"k1", "arm"}


def test_one_side_of_a_step_is_enough_and_a_model_that_fails_as_drawn_is_refused():
    run, now = read(SPRINGS, under(), 2), read(SPRINGS, under(), 1, k2=10.5)
    half, _ = counted(lambda p, loads: p["k2"] > 12.0)
    assert diagnose(now, half, commissioning=run, budget=Budget(60)).which[0].effects == ("k2",)
    never, _ = counted(lambda p, loads: loads["force"] > 50.0)
    with pytest.raises(TwinError, match=r"the model raised RuntimeError at k1 10, k2 12, arm 0\.5, force 60: no conv"):
        diagnose(now, never, commissioning=run, budget=Budget(60))


def test_what_stands_in_for_a_model_is_exact_where_that_is_square_and_refuses_far_loads():
    def bowl(p, loads):
        return [p["a"] ** 2 * loads["q"] ** 3, p["a"] + loads["q"] ** 2]

    twin = function_twin(bowl, {"x": "mm", "y": "mm"}, {"a": (2.0, 1.0, 3.0)}, loads=("q",))
    now = read(twin, [{"q": q} for q in (1.0, 2.0, 3.0)], 1, sd=np.array([0.01, 0.01]), a=2.4)
    found = diagnose(now, twin, budget=Budget(30))
    assert found.constants[0].mean == pytest.approx(2.4, abs=0.02)
    stand_in = found.posterior.model.inputs.twin.twin
    for q in (1.0, 2.0, 3.0):
        assert stand_in.function({"a": 2.7}, {"q": q}) == pytest.approx(bowl({"a": 2.7}, {"q": q}))
    with pytest.raises(TwinError, match="was not asked near q 9"):
        stand_in.function({"a": 2.0}, {"q": 9.0})


def test_answers_of_other_loads_on_disk_do_not_make_a_budget_reach(tmp_path):
    file = tmp_path / "answers.jsonl"
    far, _ = counted()
    diagnose(read(SPRINGS, under((15.0, 35.0, 55.0)), 1), far, budget=Budget(60, answers=file))
    twin, asked = counted()
    with pytest.raises(DataError, match="expected 15 or more"):
        diagnose(read(SPRINGS, under(), 1), twin, budget=Budget(14, answers=file))
    assert not asked


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (["--constants", "-5"], "--constants is -5; expected per cent above 0, up to 50"),
        (["--constants", "500"], "--constants is 500; expected per cent above 0, up to 50"),
        (["--jobs", "2"], "--jobs is for a budget of calls; expected --calls N beside it"),
        (["--answers", "x.jsonl"], "--answers is for a budget of calls"),
        (["--calls", "9", "--jobs", "0"], "the budget has 0 jobs"),
    ],
)
def test_the_command_refuses_options_of_a_model_that_say_nothing(words, told, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(tmp_path)
    Path("model_here.py").write_text("def spring(p, loads):\n    return [loads['force'] / p['k']]\n")
    Path("card.json").write_text('{"readings": {"u": "mm"}, "loads": ["force"], "parameters": {"k": [10, 5, 14]}}')
    rows = [f"T,{f},{f / 10 + 0.01 * (k % 3)}" for f in (10, 20) for k in range(6)]
    Path("now.csv").write_text("\n".join(["test,force,u", *rows]))
    with pytest.raises(SystemExit) as ended:
        sys.exit(main(["diagnose", "now.csv", "--twin", "python:model_here:spring", "--card", "card.json", *words]))
    assert ended.value.code not in (0, None)
    assert told in capsys.readouterr().err


@pytest.mark.parametrize(("low", "high"), [(9.7, 10.3), (9.9, 10.9), (5.0, 10.05), (9.65, 10.1)])
def test_a_slope_is_taken_inside_the_range_however_narrow_that_is(low, high):
    there, step = Range(10.0, low, high).ahead(0.8)
    assert low < there < high
    assert there == pytest.approx(10.0 + step * 0.8)
    assert abs(there - 10.0) > 0.4 * max(10.0 - low, high - 10.0) or abs(step) == 0.5
