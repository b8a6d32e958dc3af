"""octmip worst-case: text, JSON, a tree file that certifies, refusals."""

import json
from pathlib import Path
from typing import Any

import jsonschema

import octmip

SCHEMA = Path(octmip.__file__).parent / "interfaces" / "schemas" / "worst_case.schema.json"
ASKED = ("--label", "y", "--features", "a,b", "--depth", 1)


def test_a_tree_is_shown_with_its_worst_case_and_certifies_without_drift(run: Any, data: Path, tmp_path: Path) -> None:
    tree = tmp_path / "tree.json"
    code, out, err = run("worst-case", data, *ASKED, "--off", "a=0.2", "--out", tree)
    assert (code, err) == (0, "")
    assert out.startswith("worst case ")
    assert "| gauges off" in out
    assert "Proven: no tree of this depth has a worst case below" in out
    assert run("certify", tree, data)[0] == 0


def test_json_keeps_to_its_schema_and_names_every_set_of_gauges(run: Any, data: Path) -> None:
    code, out, _ = run("worst-case", data, *ASKED, "--off", 0.2, "--off", "b=0:1", "--gauges-off", 2, "--json")
    found = json.loads(out)
    jsonschema.Draft202012Validator(json.loads(SCHEMA.read_text())).validate(found)
    assert code == 0
    assert found["is_optimal"]
    assert found["bound"] == found["worst_case"] == max(entry["cost"] for entry in found["by_gauges"])
    assert found["plain_bound"] <= found["plain"] <= found["constant"]["cost"] <= found["worst_case"]


def test_wrong_amounts_are_refused(run: Any, data: Path) -> None:
    for words, reason in (("x", "expected an amount such as 0.3"), ("c=1", "neither a sensor"), ("a=-1", "0 or more")):
        code, _, err = run("worst-case", data, *ASKED, "--off", words)
        assert code == 2
        assert reason in err
