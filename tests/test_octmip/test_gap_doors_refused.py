"""What the doors refuse, each in one sentence with its cure."""

import pytest

from octmip.errors import DataError
from octmip.gap.doors import open_twin, read_card, table_twin
from tests.test_octmip.test_gap_doors import beside


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


def test_a_wrong_door_or_program_is_one_sentence_with_its_cure(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(
        DataError, match=r"'nodoor' cannot be imported .*expected MODULE:NAME, or a door such as table:"
    ):
        open_twin("nodoor:beam")


@pytest.mark.parametrize(
    ("name", "told"),
    [
        ("table:beam.csv", r"^table beam.csv is not there; expected a CSV or Parquet file"),
        ("table:here.csv", r"^card here.csv.json is not there: .*--card"),
    ],
)
def test_what_is_not_there_is_named_the_model_before_its_card(tmp_path, monkeypatch, name, told):
    monkeypatch.chdir(tmp_path)
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
