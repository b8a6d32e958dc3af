"""A small sealed set on coarse meshes: the machinery, the seals, the guards, and scores far from chance."""

import ast
import json
from pathlib import Path

import pytest

from benchmarks.blind import __main__ as blind
from benchmarks.blind.score import figures, is_right, open_keys, share

ROOT = Path(__file__).parents[2] / "benchmarks" / "blind"


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("blind") / "set"
    blind.run(folder, seed=11, count=12, jobs=1, without=0.0, n_lasso=1, asset_mesh=0.5, twin_mesh=0.4)
    return folder


def test_a_small_set_is_far_from_chance(folder):
    answers = open_keys(folder, folder.parent / "set.keys.json")
    found = [json.loads(line) for line in (folder / "diagnoses.jsonl").read_text().splitlines()]
    rows = {row.name: row for row in figures([f for f in found if f["calibrated"]], answers)}
    assert rows["top-1 by ambiguity group, all"].value >= 0.5
    assert rows["false alarm, white noise"].value <= 0.5
    assert "shuffled keys" in (folder / "tables.md").read_text()


def test_a_changed_key_breaks_its_seal(folder, tmp_path):
    answers = json.loads((folder.parent / "set.keys.json").read_text())
    first = next(iter(answers.values()))
    first["case"]["truths"] = [{"name": "modulus", "size": 9.9, "place": "", "extra": {}}]
    changed = tmp_path / "keys.json"
    changed.write_text(json.dumps(answers))
    with pytest.raises(SystemExit, match="seals"):
        open_keys(folder, changed)


def test_the_campaigns_tell_no_answer(folder):
    text = "".join(path.read_text() for path in (folder / "campaigns").glob("*.csv"))
    assert not any(name in text for name in ("gain", "temperature_u", "modulus", "outside"))


def test_the_case_maker_knows_nothing_of_the_diagnosis():
    for name in ("asset", "truths", "cases"):
        tree = ast.parse((ROOT / f"{name}.py").read_text())
        imported = {node.module for node in ast.walk(tree) if isinstance(node, ast.ImportFrom)}
        assert not any(m.startswith(("octmip", "femlib.wing.effects", "benchmarks.blind.answers")) for m in imported)


def test_a_set_is_right_when_each_group_holds_one_truth():
    assert is_right([["a", "b"], ["c"]], ["c", "b"])
    assert not is_right([["a", "b"], ["c"]], ["a", "b"])
    assert is_right([], []) and not is_right([], ["a"])


def test_a_share_has_its_exact_interval():
    row = share("x", [True] * 9 + [False])
    assert row.value == pytest.approx(0.9)
    assert row.low == pytest.approx(0.555, abs=1e-3) and row.high == pytest.approx(0.9975, abs=1e-3)
