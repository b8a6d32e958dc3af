"""octmip near-optimal and octmip sensors: text, JSON by its schema, pictures and refusals."""

import json
from pathlib import Path
from typing import Any

import jsonschema
import pytest

import octmip
from octmip.errors import DataError
from octmip.interfaces.cli.answer import rounded
from octmip.interfaces.cli.sets.amount import amount_of

SCHEMAS = Path(octmip.__file__).parent / "interfaces" / "schemas"
ASKED = ("--label", "y", "--features", "a,b")


def checked(text: str, name: str) -> dict[str, Any]:
    """Return a JSON object that its schema allows."""
    schema = json.loads((SCHEMAS / f"{name}.schema.json").read_text())
    jsonschema.Draft202012Validator.check_schema(schema)
    found: dict[str, Any] = json.loads(text)
    jsonschema.Draft202012Validator(schema).validate(found)
    return found


def test_a_set_as_json_keeps_to_its_schema(run: Any, data: Path) -> None:
    words = ("--depth", 2, "--within", "100%", "--best", 3, "--sample", 2, "--sets", "--json")
    found = checked(run("near-optimal", data, *ASKED, *words)[1], "near_optimal")
    assert found["is_complete"]
    assert found["trees"] == sum(entry["trees"] for entry in found["spectrum"])
    assert found["trees"] == sum(entry["trees"] for entry in found["by_sensors"])
    assert [len(found[name]) for name in ("best", "samples", "open")] == [3, 2, 0]


def test_a_set_that_is_not_counted_says_so(run: Any, data: Path) -> None:
    words = ("--depth", 3, "--within", 2, "--seconds", 0, "--sample", 1)
    code, out, err = run("near-optimal", data, *ASKED, *words)
    assert (code, err) == (0, "")
    assert "Not complete (stop: time)" in out
    assert "No sample is drawn from it" in out
    found = checked(run("near-optimal", data, *ASKED, *words, "--json")[1], "near_optimal")
    assert (found["trees"], found["samples"]) == (None, [])


def test_sensors_as_json_keep_to_their_schema(run: Any, data: Path) -> None:
    found = checked(run("sensors", data, *ASKED, "--depth", 1, "--pairs", "--within", "1%", "--json")[1], "sensors")
    assert [entry["role"] for entry in found["sensors"]] == ["needed", "useless"]
    assert found["sensors"][0]["without"]["reads"] == ["b"]
    assert found["pairs"][0]["reads"] == []


def test_sensors_without_time_carry_question_marks(run: Any, data: Path) -> None:
    out = run("sensors", data, *ASKED, "--depth", 3, "--seconds", 0)[1]
    assert "Not all proven (stop: time)" in out
    assert "?" in out.splitlines()[4]


@pytest.mark.parametrize(
    ("command", "words", "message"),
    [
        ("near-optimal", ("--within", "-1"), "--within is '-1'; expected an amount"),
        ("near-optimal", ("--within", "1%%"), "--within is '1%%'"),
        ("near-optimal", ("--best", 10**6), "expected 0 to 1000 trees"),
        ("near-optimal", ("--split", "hyperplane"), "split is 'hyperplane'"),
        ("sensors", ("--out", "sensors.txt"), "--out sensors.txt is no picture"),
    ],
)
def test_what_cannot_be_answered_is_refused(refused: Any, data: Path, command: str, words: Any, message: str) -> None:
    assert message in refused(command, data, *ASKED, "--depth", 2, *words)


def test_an_amount_is_a_number_or_a_share() -> None:
    assert (amount_of("0.3").within, amount_of("0.3").relative) == (0.3, None)
    assert amount_of("29%").relative is not None
    assert amount_of("29%").above(200.0) == 58.0
    with pytest.raises(DataError, match="expected an amount"):
        amount_of("1e999")


def test_whole_numbers_of_a_table_stay_whole():
    assert [rounded(value) for value in (12345678, 12345678.9, None)] == [12345678, 12345700.0, None]
