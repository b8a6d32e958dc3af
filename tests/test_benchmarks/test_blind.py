"""A small sealed set: the machinery, the seals, the guards, and the scores of answers that are right.

The set is answered by one that has seen the keys: seals, tables and scores are what is tested here. The diagnosis
itself answers three cases that are clear.
"""

import ast
import json
from dataclasses import asdict
from pathlib import Path

import numpy as np
import pytest

from benchmarks.blind import run as blind
from benchmarks.blind.answers import Task
from benchmarks.blind.assets.beam.asset import BeamAsset
from benchmarks.blind.assets.families import made
from benchmarks.blind.cases import ALL_LOADS, Case, mean_readings, moments, write_campaign, write_run
from benchmarks.blind.guards import chance, shuffled
from benchmarks.blind.score import CLEAR, closed, d_prime, figures, localised, names_of, size_held, top
from benchmarks.blind.sealing import distance, facts
from benchmarks.blind.selectors import answer
from benchmarks.blind.truths import Truth
from benchmarks.figure import Figure, calibration, share
from benchmarks.seals import is_right, open_keys

ROOT = Path(__file__).parents[2] / "benchmarks" / "blind"
CASE_MAKER = tuple(
    str(path.relative_to(ROOT).with_suffix(""))
    for path in [
        *ROOT.glob("assets/**/*.py"),
        *(ROOT / f"{name}.py" for name in ("truths", "cases", "sealing", "noises", "singles")),
    ]
    if path.name != "__init__.py"
)


@pytest.fixture(scope="module")
def strips():
    """The asset of another hand, of a third of the strips that it has in a study: solved once for all these tests."""
    return BeamAsset(11, n_stations=41)


def test_a_family_is_made_by_its_name(tmp_path):
    assert isinstance(made("beam", 11, tmp_path / "set.keys.json"), BeamAsset)
    with pytest.raises(SystemExit, match=r"no family .paper.; expected one of springs, beam; correct --family"):
        made("paper", 11, tmp_path / "set.keys.json")


def told(name, key, is_calibrated):
    """Return the truth as an answer."""
    names = names_of(key)
    effects = ["unknown"] if names == ["outside"] else names
    groups = [[name] for name in effects]
    return {
        "name": name, "calibrated": is_calibrated, "seconds": 1.0,
        "which": [{"effects": effects, "probability": 0.9, "parameters": []}],
        "names": [groups], "credible": [groups], "unknown_probability": float(names == ["outside"]),
        "findings": [], "stuck": [], "significant": [], "correction": key["held_change"], "doubts": [],
    }  # fmt: skip


@pytest.fixture(scope="module")
def folder(tmp_path_factory, strips):
    folder = tmp_path_factory.mktemp("blind") / "set"
    plan = blind.Plan(11, count=16, jobs=1, without=0.1, families=("beam",), twin_mesh=0.3)

    def select(task):
        key = json.loads((folder.parent / "set.keys.json").read_text())[task.name]
        kinds = (True, False) if task.without else (True,)
        return [told(task.name, key, is_calibrated) for is_calibrated in kinds]

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(blind, "answer", select)
        patch.setattr(blind, "made", lambda *_: strips)
        blind.run(folder, plan)
    return folder


@pytest.fixture(scope="module")
def cases(folder):
    answers = open_keys(folder, folder.parent / "set.keys.json")
    found = [json.loads(line)[0] for line in (folder / "diagnosis.jsonl").read_text().splitlines()]
    return [(f, answers[f["name"]]) for f in found]


def test_a_small_set_is_scored_by_its_keys(cases):
    rows = {row.name: row for row in figures(cases)}
    assert rows["top-1 by ambiguity group, d' >= 5"].value == 1.0
    assert rows["false alarm, white noise"].value == 0.0
    assert rows["outside the library, AUROC (d' > 3)"].value == 1.0
    assert rows["closed on a held-out load, median"].value == 1.0


@pytest.fixture(scope="module")
def diagnosed(tmp_path_factory, strips):
    """Return what the diagnosis says of three clear cases of the strips, and the facts of each."""
    asset, place = strips, tmp_path_factory.mktemp("clear")
    (place / "campaigns").mkdir()
    write_run(place / "commissioning.csv", asset, 11)
    truths = {
        "none": (),
        "single": (Truth("temperature_uniform", 15.0),),
        "gauge": (Truth("gauge_bias", 60.0, "g05"),),
    }
    found = {}
    for name, acting in truths.items():
        case = Case(name, name, acting, ((0.0, 0.0),), True, ALL_LOADS, "white", asset.family)
        write_campaign(place / "campaigns" / f"{name}.csv", case, asset, 11)
        (told,) = answer(Task(place, name, 0.3, without=False))
        found[name] = (told, {"case": json.loads(json.dumps(asdict(case))), **facts(case, asset)})
    return found


@pytest.mark.long
@pytest.mark.parametrize("name", ["none", "single", "gauge"])
def test_the_diagnosis_is_right_about_a_clear_case_of_another_hand(diagnosed, name):
    found, key = diagnosed[name]
    assert top(found, key)
    if name != "none":
        assert closed(found, key) > 0.8
        assert localised(found, key)[0] >= 0.8


def test_shuffled_keys_score_at_chance(cases):
    clear = [(f, a) for f, a in cases if a["case"]["stratum"].startswith("single") and d_prime(f, a) >= CLEAR]
    luck, level = shuffled(clear), chance(clear).value
    assert luck.low <= level <= luck.high
    assert np.mean([top(f, a) for f, a in clear]) > luck.value + 0.2


def test_a_changed_key_breaks_its_seal(folder, tmp_path):
    answers = json.loads((folder.parent / "set.keys.json").read_text())
    next(iter(answers.values()))["case"]["truths"] = [{"name": "modulus", "size": 9.9, "place": "", "extra": {}}]
    changed = tmp_path / "keys.json"
    changed.write_text(json.dumps(answers))
    with pytest.raises(SystemExit, match="1 answers do not match their seals"):
        open_keys(folder, changed)


@pytest.mark.long
def test_a_set_that_was_stopped_goes_on_where_it_was(folder, monkeypatch):
    path = folder / "diagnosis.jsonl"
    whole = path.read_text()
    *before, last = whole.splitlines(keepends=True)
    asked = []
    monkeypatch.setattr(blind, "answer", lambda task: asked.append(task.name) or json.loads(last))
    path.write_text("".join([*before, last[:50]]))
    begun = json.loads((folder / "plan.json").read_text())
    text = blind.run(folder, blind.plan_of(begun, jobs=1))
    assert asked == [json.loads(last)[0]["name"]]
    assert path.read_text() == whole
    assert text.startswith(f"Seed 11, {len(whole.splitlines())} cases")  # the plan is the set's own


def test_the_campaigns_tell_no_answer(folder):
    text = "".join(path.read_text() for path in folder.glob("*/campaigns/*.csv"))
    header, *_ = text.splitlines()
    rows = {line for line in text.splitlines() if line != header}
    assert header.startswith("test,load_factor,mu1,mu2,time,g01")
    assert all(set(row) <= set("0123456789.,-T") for row in rows)


def test_a_task_names_neither_seed_nor_keys(folder):
    (task, *_) = blind._tasks(folder, blind.Plan(11))
    assert set(Task.__dataclass_fields__) == {
        "place",
        "name",
        "refinement",
        "without",
        "selector",
    }
    assert not any(word in str(task) for word in ("keys", "seed"))


def is_package(module):
    return (ROOT.parents[1] / module.replace(".", "/")).is_dir()


@pytest.mark.parametrize("name", [*CASE_MAKER, "../noises"])
def test_the_case_maker_knows_nothing_of_the_diagnosis(name):
    tree = ast.parse((ROOT / f"{name}.py").read_text())
    imported = {
        f"{node.module}.{alias.name}" if is_package(node.module) else node.module
        for node in ast.walk(tree)
        if isinstance(node, ast.ImportFrom)
        for alias in node.names
    }
    imported |= {alias.name for node in ast.walk(tree) if isinstance(node, ast.Import) for alias in node.names}
    own = {m.removeprefix("benchmarks.blind.").replace(".", "/") for m in imported if m.startswith("benchmarks.blind.")}
    assert own <= set(CASE_MAKER)
    assert not any(m.startswith(("octmip", "femlib.wing.effects", "femlib.wing.twin")) for m in imported)


class Line(BeamAsset):
    """An asset of two gauges without a wing: strain 1000 and 500 whatever the state."""

    def __init__(self):
        self.gauges, self.eta, self.states = ("a", "b"), np.array([0.3, 0.5]), ((0.0, 0.0),)

    def strain(self, state):
        return np.array([1000.0, 500.0])

    def softness(self, state):
        return np.ones(2)


def test_d_prime_of_a_bias_is_its_size_over_the_noise_of_all_means():
    case = Case("x", "single", (Truth("gauge_bias", 20.0, "a"),), ((0.0, 0.0),), True, (0.0,), "white", "line")
    (moment,) = moments(case)
    moved = mean_readings(case.truths, Line(), moment) - moment.load * Line().strain((0.0, 0.0))
    assert distance(moved[:1], case, Line(), True) == pytest.approx(20.0 / np.sqrt(1000.0 / 50))


def test_without_a_commissioning_run_a_scale_is_hard_to_see():
    case = Case("x", "single", (Truth("modulus", 1.0),), ((0.0, 0.0),), True, (3.0,), "white", "line")
    (moment,) = moments(case)
    moved = (mean_readings(case.truths, Line(), moment) - 3.0 * Line().strain((0.0, 0.0))).mean(axis=0)[None]
    assert distance(moved, case, Line(), False) < 1.0 < distance(moved, case, Line(), True)


def test_a_part_of_a_pair_counts_as_far_as_the_other_cannot_imitate_it():
    case = Case("x", "pair", (), ((0.0, 0.0),), True, (0.0,), "white", "line")
    first, second = np.array([[30.0, 0.0]]), np.array([[30.0, 40.0]])
    alone = distance(first, case, Line(), True)
    assert distance(first, case, Line(), True, beside=second) == pytest.approx(0.8 * alone)
    assert distance(first, case, Line(), True, beside=2.0 * first) == pytest.approx(0.0, abs=1e-6)


def test_a_set_is_right_when_each_group_holds_one_truth():
    assert is_right([["a", "b"], ["c"]], ["c", "b"])
    assert not is_right([["a", "b"], ["c"]], ["a", "b"])
    assert is_right([], [])
    assert not is_right([], ["a"])


def test_the_interval_of_a_size_counts_only_where_name_and_gauge_are_right():
    def hit(place, low, high):
        parameter = {"effect": "gauge_gain", "place": place, "low": low, "high": high}
        truth = {"name": "gauge_gain", "size": 2.0, "place": "g03"}
        return size_held({"which": [{"parameters": [parameter]}]}, {"case": {"truths": [truth]}})

    assert hit("g03", 1.5, 2.5) is True
    assert hit("g03", 2.1, 2.5) is False
    assert hit("g04", 1.5, 2.5) is None


def test_a_share_has_its_exact_interval():
    row = share("x", [True] * 9 + [False])
    assert row.value == pytest.approx(0.9)
    assert row.low == pytest.approx(0.555, abs=1e-3)
    assert row.high == pytest.approx(0.9975, abs=1e-3)


def test_a_figure_says_whether_it_is_what_is_owed():
    assert Figure("x", 0.96, 0.9, 1.0, 5, (0.95, np.inf)).words().endswith("met")
    assert Figure("x", 0.94, 0.9, 1.0, 5, (0.95, np.inf)).words().endswith("**missed**")
    assert Figure("x", 1.0, 0.9, 1.0, 5, (0.93, 0.99)).words().endswith("**above**")
    assert Figure("x", 0.94, 0.9, 1.0, 5, (-np.inf, 0.05)).owed() == "<= 0.05"


def test_calibration_is_exact_for_one_stated_probability():
    assert calibration("x", [0.8] * 10, [True] * 6 + [False] * 4, bins=1).value == pytest.approx(0.2)
