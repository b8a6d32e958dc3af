"""What once ended in a traceback, a warning, a hang or a command: each file with the sentence that it now ends in."""

import os
from pathlib import Path

import numpy as np
import pandas as pd
import pyarrow as pa
import pytest
from pyarrow import parquet

from femlib.files import whole_file
from octmip import Leaf, Split
from octmip.errors import DataError, OctmipError, TreeError
from octmip.formats.table import parquet as parquet_table
from octmip.formats.table import read_table
from octmip.gap import read_campaign
from octmip.input.files import check_writable, read_json_object, read_text, whole_folder, write_bytes
from octmip.monitor import Library, ModelSelector


@pytest.mark.parametrize(
    ("cell", "sentence"),
    [
        ("9" * 400, "line 3, column 'x': a whole number of more than 60 digits is beyond 2"),
        ("-9223372036854775807", "line 3, column 'x': -9223372036854775807 is beyond 2"),
        ('"1,000"', "column 'x' holds '1,000', which may be 1000 or 1"),
        *((cell, f"line 3, column 'x': '{cell}' is no number") for cell in ("1_000", "\u0661\u0662", "0x10", "True")),
        ("a" * 100_000, r"'aaa[a]*\.\.\. is no number"),
        ("\x1b[2J", r"'\\x1b\[2J' is no number"),
    ],
)
def test_a_hostile_cell_is_refused_with_its_line(tmp_path, cell, sentence):
    path = tmp_path / "data.csv"
    path.write_text(f"x,y\n1,a\n{cell},b\n")
    with pytest.raises(DataError, match=sentence) as error:
        read_table(path).numbers(["x"])
    assert len(str(error.value)) < 1000
    assert str(error.value).isprintable()


@pytest.mark.parametrize(
    ("content", "sentence"),
    [
        (b"\xff\xfex\x00,", "line 1: byte 0x2c is not UTF-16"),
        (b"a" * 1001 + b",y\n1,2\n", "a column whose name has 1001 characters"),
        (b"x,y\n1," + b"a" * 1001 + b"\n", "has 1001 characters; expected at most 1000"),
    ],
)
def test_a_hostile_table_is_refused(tmp_path, content, sentence):
    path = tmp_path / "data.csv"
    path.write_bytes(content)
    with pytest.raises(DataError, match=sentence):
        read_table(path).labels("y")


@pytest.mark.parametrize(
    ("columns", "sentence"),
    [
        ([pa.array([[1.0], [2.0]])], r"row 1, column 'x': .* is no number"),
        ([pa.array([{"a": 1}] * 2)], "row 1, column 'x': an object of 1 is no number"),
        ([pa.array([0, 1], pa.timestamp("s"))], "row 1, column 'x': .* is no number"),
        ([pa.array([b"\xff", b"a"])], "is no number"),
        ([pa.array([1.0, None])], "row 2, column 'x': the feature is empty"),
        ([pa.array([1, 2**63 + 1], pa.uint64())], "row 2, column 'x': 9223372036854775809 is beyond"),
        ([pa.array([1, 2]), pa.array([1, 2])], "has the column 'x' 2 times"),
        ([], "0 columns and 0 rows"),
    ],
)
def test_a_hostile_parquet_column_is_refused(tmp_path, columns, sentence):
    parquet.write_table(pa.Table.from_arrays(columns, ["x"] * len(columns)), tmp_path / "data.parquet")
    with pytest.raises(DataError, match=sentence):
        read_table(tmp_path / "data.parquet").numbers(["x"])


def table_that_pandas_wrote(path, about):
    """Write a Parquet table with `about` as the metadata of pandas, and return its file."""
    frame = pa.table({"x": [1.0, 2.0], "y": ["a", "b"]}).replace_schema_metadata({b"pandas": about})
    parquet.write_table(frame, path)
    return path


@pytest.mark.parametrize("about", [b"[]", b'{"index_columns": 5}', b'{"index_columns": ["x"], "columns": 7}'])
def test_what_pandas_wrote_beside_a_parquet_table_is_not_believed(tmp_path, about):
    path = table_that_pandas_wrote(tmp_path / "data.parquet", about)
    assert read_table(path).labels("y").tolist() == ["a", "b"]


def test_metadata_of_pandas_that_are_no_json_are_refused(tmp_path):
    path = table_that_pandas_wrote(tmp_path / "data.parquet", b"{")
    with pytest.raises(DataError, match="no Parquet file that can be read"):
        read_table(path)


def test_a_parquet_table_of_a_named_index_has_its_columns_only(tmp_path):
    pd.DataFrame({"x": [1.0, 2.0]}, index=pd.Index(["r1", "r2"], name="row")).to_parquet(tmp_path / "data.parquet")
    assert read_table(tmp_path / "data.parquet").columns == ("x",)


def test_a_parquet_table_that_promises_more_than_memory_is_refused(tmp_path, monkeypatch):
    parquet.write_table(pa.table({"x": np.zeros(5000)}), tmp_path / "data.parquet")
    monkeypatch.setattr(parquet_table, "MOST_CELLS", 4999)
    with pytest.raises(DataError, match="holds 5000 rows of 1 columns; expected at most 4999 cells"):
        read_table(tmp_path / "data.parquet")


def selector_file(tmp_path):
    states, strains = np.array([[0.0], [0.5]]), np.array([[1.0, 2.0], [3.0, 4.0]])
    library = Library(("mu",), states, ("g1", "g2"), strains, np.ones(2))
    ModelSelector(library, Split(0, 2.0, Leaf(0), Leaf(1))).write(tmp_path / "s.json")
    return tmp_path / "s.json"


@pytest.mark.parametrize(
    ("old", "new", "sentence"),
    [
        ('"noise_sd": [\n  1.0', '"noise_sd": [\n  1e999', r"noise_sd\[0\] is inf; expected a finite number"),
        ('"noise_sd": [\n  1.0', '"noise_sd": [\n  0', r"noise_sd\[0\] is 0; expected a finite number of 1e-15"),
        ('"only_load": null', '"only_load": "1"', "only_load is '1'; expected a finite number"),
        ('"mu=0.5"', '"mu=0"', "state_names holds 'mu=0' 2 times"),
        ('"g2"', "[]", r"gauges\[1\] is \[\]; expected a text"),
        ('"threshold": 2.0', '"threshold": ' + "9" * 400, "tree.threshold is a whole number of more than 60 digits"),
        ('"threshold": 2.0', '"threshold": 1, "threshold": 2', "names 'threshold' twice"),
    ],
)
def test_a_hostile_selector_is_refused_with_its_place(tmp_path, old, new, sentence):
    path = selector_file(tmp_path)
    text = path.read_text()
    assert old in text
    path.write_text(text.replace(old, new))
    with pytest.raises(OctmipError, match=sentence):
        ModelSelector.read(path)


def test_states_of_one_name_are_not_written(tmp_path):
    states = np.array([[0.12345678], [0.12345679]])
    library = Library(("mu",), states, ("g1",), np.zeros((2, 1)), np.ones(1))
    with pytest.raises(TreeError, match=r"state_names holds 'mu=0\.123457' 2 times"):
        ModelSelector(library, Split(0, 0.0, Leaf(0), Leaf(1))).write(tmp_path / "s.json")


class Beam:
    gauges, parameters, effects = ("g1", "g2"), ("mu1",), {}

    def predict(self, state, load_factor):
        return load_factor * np.array([900.0, 500.0])


def test_a_load_beyond_all_loads_is_refused_before_the_twin_is_asked(tmp_path):
    path = tmp_path / "campaign.csv"
    path.write_text("test,load_factor,g1,g2\na,1,900,500\na,1e308,900,500\n")
    with pytest.raises(DataError, match=r"row 3, column load_factor is 1e\+308; expected a load factor"):
        read_campaign(path, Beam())


def test_a_label_column_of_lists_is_no_column_of_labels(tmp_path):
    parquet.write_table(pa.table({"x": [1.0, 2.0], "y": [["a"], ["b"]]}), tmp_path / "data.parquet")
    assert not read_table(tmp_path / "data.parquet").missing("y", "label").any()


@pytest.mark.parametrize(
    ("error", "ends"), [(OSError(28, "No space left on device"), DataError), (KeyboardInterrupt(), KeyboardInterrupt)]
)
def test_a_write_that_fails_or_is_interrupted_leaves_the_old_file_and_nothing_else(tmp_path, monkeypatch, error, ends):
    target = tmp_path / "a.json"
    target.write_bytes(b"old")

    def fails(descriptor):
        raise error

    monkeypatch.setattr(os, "fsync", fails)
    with pytest.raises(ends, match="No space left" if ends is DataError else None):
        write_bytes(target, b"new")
    assert target.read_bytes() == b"old"
    assert len(list(tmp_path.iterdir())) == 1


def test_a_link_stays_and_its_target_is_replaced(tmp_path):
    (tmp_path / "target").write_bytes(b"old")
    (tmp_path / "link").symlink_to(tmp_path / "target")
    write_bytes(tmp_path / "link", b"new")
    assert (tmp_path / "link").is_symlink()
    assert (tmp_path / "target").read_bytes() == b"new"


def test_a_device_is_written_to_as_it_is():
    write_bytes("/dev/null", b"gone")
    check_writable("/dev/null")
    assert Path("/dev/null").is_char_device()


def test_a_file_gets_the_permissions_of_the_user(tmp_path):
    write_bytes(tmp_path / "a", b"1")
    (tmp_path / "b").write_bytes(b"1")
    with whole_file(tmp_path / "c") as passing:
        passing.write_bytes(b"1")
    assert len({(tmp_path / name).stat().st_mode for name in "abc"}) == 1


@pytest.mark.parametrize("mode", [0o600, 0o640, 0o444])
def test_a_file_that_is_written_again_keeps_its_permissions(tmp_path, mode):
    for name in "abc":
        (tmp_path / name).write_bytes(b"old")
        (tmp_path / name).chmod(mode)
    write_bytes(tmp_path / "a", b"new")
    with whole_folder(tmp_path) as passing:
        (passing / "b").write_bytes(b"new")
    with whole_file(tmp_path / "c") as passing:
        passing.write_bytes(b"new")
    assert [(file.read_bytes(), file.stat().st_mode & 0o777) for file in tmp_path.iterdir()] == [(b"new", mode)] * 3


@pytest.mark.parametrize(("name", "reason"), [("", "is a folder"), ("none/a.json", "there is no folder")])
def test_a_place_that_cannot_be_written_is_refused_beforehand(tmp_path, name, reason):
    with pytest.raises(DataError, match=reason):
        check_writable(tmp_path / name)


@pytest.mark.parametrize(
    ("content", "reason"),
    [
        (b"", "is empty"),
        (b" \n", "is empty"),
        (b"ab\n\xff\xfe", "line 2: byte 0xff is not UTF-8"),
    ],
)
def test_text_that_cannot_be_read_says_why(tmp_path, content, reason):
    (tmp_path / "a").write_bytes(content)
    with pytest.raises(DataError, match=reason):
        read_text(tmp_path / "a")


@pytest.mark.parametrize(
    ("content", "reason"),
    [
        ('{"a": [1, 2', "ends in the middle"),
        ('{"a": "tex', "ends in the middle"),
        ('{"a": 1,}', "line 1"),
        ("[1]", "holds a JSON list"),
        ('{"a": NaN}', "NaN is no JSON number"),
        ('{"a": ' + "[" * 200_000, "nested deeper than 100 levels"),
        ('{"a": ' + "[" * 101 + "]" * 101 + "}", "nested deeper than 100 levels"),
        ('{"a": 1, "a": 2}', "names 'a' twice"),
        ('{"a": "\\ud800"}', "surrogates not allowed"),
        ('{"a": ' + "9" * 5000 + "}", "4300"),
        ("a,b\n1,2\n", r"begins with 'a,b'; expected JSON: one object \{...\}"),
        ("true,b\n1,2\n", "begins with 'true,b'; expected JSON"),
    ],
)
def test_json_that_cannot_be_read_says_why(tmp_path, content, reason):
    (tmp_path / "a").write_text(content)
    with pytest.raises(DataError, match=reason):
        read_json_object(tmp_path / "a")


def test_nothing_but_a_regular_file_is_read_and_nothing_is_waited_for(tmp_path):
    os.mkfifo(tmp_path / "pipe")
    for path in (tmp_path / "pipe", "/dev/zero", tmp_path):
        with pytest.raises(DataError, match=r"it is a (pipe or device|folder)\); expected a regular file"):
            read_text(path)
    with pytest.raises(DataError, match="null byte"):
        read_text("a\0b")
