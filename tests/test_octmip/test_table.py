"""Tables: every wrong cell is refused with its file, line and column, and every right one is read to the last bit."""

import gzip
import io
from collections.abc import Callable
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest

from octmip.errors import DataError
from octmip.formats.table import read_costs, read_sensors, read_table
from octmip.formats.table.preparation import kept_rows
from octmip.formats.table.source import open_source


def csv_file(tmp_path, text):
    path = tmp_path / "data.csv"
    path.write_bytes(text.encode())
    return path


@pytest.mark.parametrize(
    "cells",
    ["1,2,3,4.5,5", "1,2,,4,5", "a,b,1.0,c,2", "1,2,9007199254740993,,5", "1.10,1.1,x,2,3", ",,3,4,x", ",,,,1"],
)
def test_a_table_in_pieces_is_the_table_read_at_once(cells, tmp_path, monkeypatch):
    rows = "\n".join(f"{cell},{k},w{k}" for k, cell in enumerate(cells.split(",")))
    (tmp_path / "t.csv").write_text(f"a,b,c\n{rows}\n")
    whole = read_table(tmp_path / "t.csv").frame
    monkeypatch.setattr("octmip.formats.table.delimited.LONG", 0)
    monkeypatch.setattr("octmip.formats.table.delimited.PIECE", 2)
    pd.testing.assert_frame_equal(read_table(tmp_path / "t.csv").frame, whole)


def test_numbers_are_read_to_the_last_bit(tmp_path):
    values = np.random.default_rng(0).normal(size=200) * 10.0 ** np.arange(-100, 100)
    path = csv_file(tmp_path, "x,y\n" + "".join(f"{v!r},a\n" for v in values.tolist()))
    assert (read_table(path).numbers(["x"])[:, 0] == values).all()


@pytest.mark.parametrize(
    ("text", "columns", "told"),
    [
        ("t\tforce\tComment\n0\t5\n1\t6\n", {"t": [0, 1], "force": [5, 6]}, ""),
        ("x,y\n1,2\n3,4\ny,x\n6,5\n", {"x": [1, 3, 5], "y": [2, 4, 6]}, "another order below line 4"),
        (
            "t,y\nTime [s],Force (N)\n1,2\n3,4\n",
            {"t": [1, 3], "y": [2, 4]},
            "line 2 under the header with the units",
        ),
        ("t,y\n,Force (N)\n1,2\n3,4\n", {"t": [1, 3], "y": [2, 4]}, "the units (y N)"),
        (
            "a,y\nway (km),\nrise (m),2\nfall (m),3\n",
            {"a": ["way (km)", "rise (m)", "fall (m)"], "y": [None, 2, 3]},
            "",
        ),
        ("note,see,below\nnote,see,beside\nnote,or,ask\nx,y\n1,a\n2,b\n3,c\n", {"x": [1, 2, 3], "y": [*"abc"]}, ""),
        ("y\n1.1\n1.2\n1.10\n", {"y": [1.1, 1.2, 1.1]}, "1.1 and 1.10 in column 'y' are one number"),
        ("y;z\n500;0.5\n3.000;1.000\n", {"y": [500, 3], "z": [0.5, 1]}, "3.000 in column 'y' has decimals"),
    ],
)
def test_comments_above_and_beside_and_another_order_of_columns_are_read(tmp_path, text, columns, told):
    table = read_table(csv_file(tmp_path, text))
    assert table.frame.astype(object).where(table.frame.notna(), None).to_dict("list") == columns
    assert told in " ".join(table.notes)


@pytest.mark.parametrize("suffix", ["csv", "parquet"])
def test_columns_come_as_numbers_and_labels(tmp_path, suffix):
    frame = pd.DataFrame({"x": [1.5, 2.5], "n": [1, 2], "b": [True, False], "y": ["NA", "None"]})
    path = tmp_path / f"data.{suffix}"
    frame.to_csv(path, index=False) if suffix == "csv" else frame.to_parquet(path)
    table = read_table(path)
    assert table.numbers(["n", "x", "b"]).tolist() == [[1, 1.5, 1], [2, 2.5, 0]]
    assert table.labels("y").tolist() == ["NA", "None"]  # names of classes, not missing values
    assert table.labels("n").tolist() == [1, 2]
    assert table.labels("b").tolist() == [True, False]


REFUSED: dict[str, tuple[Callable[[Path], Any], list[tuple[str, str]]]] = {
    "a table": (
        read_table,
        [
            ("", "is empty"),
            ("x,y\n", "2 columns and 0 rows"),
            ("x,x,y\n1,2,a\n", "column 'x' 2 times"),
            ("a,b,y\n1,2,u\n2,v\n", "line 3: 2 cells but the header has 3; give every row one for each column"),
            ('x,y\n"1\n",a\n\n2\n', "line 5: 1 cell but the header has 2"),
            ("x,y\n1,a\n2,b,c\n", "line 3: 3 cells but the header has 2"),
            ("x,y\n1,a,7\n2,b,7\n", "line 2: 3 cells but the header has 2"),
            ("x,,y\n0,1,a\n1,2,b\n", "line 1: column 2 has no name"),
            (",x,y\n0,1,a\n0,2,b\n", "line 1: column 1 has no name"),
            ('x,y\n1,"a\n2,b\n', "line 2 or below is not valid CSV .*close its quotation mark"),
            ('x,y\n"1","-0\n"2","b"\n"3","c"\n', "line 2: 3 cells but the header has 2"),
            ('x,y\n"1","a"\n"2,"b"\n"3","c"\n', "line 3: 1 cell but the header has 2"),
            ("x,y\n1," + "a" * 200_000 + "\n", "line 2: field larger than field limit"),
        ],
    ),
    "a feature": (
        lambda path: read_table(path).numbers(["x"]),
        [
            ("x,y\n1,a\nlow,b\n", "line 3, column 'x': 'low' is no number"),
            ("x,y\n1,a\n\n,b\n", "line 4, column 'x': the feature is empty"),
            ("x,y\n1,a\nnan,b\n", "line 3, column 'x'"),
            ("x,y\n1,a\ninf,b\n", "line 3, column 'x': inf is not finite"),
            ("x,y\n1,a\n9007199254740993,b\n", "line 3, column 'x': 9007199254740993 is beyond 2"),
            ('x,y\n1,"a\nb"\n?,b\n', "line 4, column 'x'"),
            ("z,y\n1,a\n", "no column 'x'; expected the feature among its 2 columns"),
        ],
    ),
    "a class": (
        lambda path: read_table(path).labels("y"),
        [(f"y\n1\n2\n{word}\n", r"line 4, column 'y': .* among numbers") for word in ("NA", "None", "?")],
    ),
    "a label": (
        lambda path: read_table(path).labels("y", known=["a", "b"]),
        [
            ("x,y\n1,a\n2,\n", "line 3, column 'y': the label is empty"),
            ("x,y\n1,a\n2,c\n", "line 3, column 'y': label 'c' was not seen at training"),
            ("x,z\n1,a\n2,c\n", "no column 'y'; expected the label"),
        ],
    ),
    "costs": (
        lambda path: read_costs(path, ["a", "b"]),
        [
            ("true,a,b\na,0,1\n", "rows 'a'; expected each of the classes"),
            ("true,a,c\na,0,1\nb,1,0\n", "columns 'a', 'c'; expected each"),
            ("true,a,b\na,0,x\nb,1,0\n", "'x' is no number, and a cost"),
            ("predicted,a,b\na,0,1\nb,1,0\n", "rows for 'predicted' classes; expected one for each true class"),
        ],
    ),
    "sensors": (
        lambda path: read_sensors(path, ["a", "b"]),
        [
            ("sensor,cost\na,1\n", "names the feature 'b' 0 times"),
            ("sensor,cost\na,1\na,2\nb,1\n", "names the feature 'a' 2 times"),
            ("feature,sensor,cost\na,left,1\nb,left,2\n", "sensor 'left' two costs, 1.0 and 2.0"),
            ("sensor,price\na,1\nb,1\n", "no column 'cost'"),
        ],
    ),
}


@pytest.mark.parametrize(("ask", "text", "sentence"), [(ask, *row) for ask, found in REFUSED.values() for row in found])
def test_what_is_wrong_in_a_table_is_refused_with_its_place(tmp_path, ask, text, sentence):
    with pytest.raises(DataError, match=sentence):
        ask(csv_file(tmp_path, text))


def test_a_row_of_codes_below_others_is_no_row_of_units(tmp_path):
    rows = "".join(f"C,{k},{k}\n" for k in range(9))
    assert len(read_table(csv_file(tmp_path, f"k,x,y\nB,1,2\nA,N,N\n{rows}")).frame) == 11


@pytest.mark.parametrize(("rows", "kept"), [("all", "pqr"), ("labelled", "pq"), ("complete", "p")])
def test_rows_are_kept_by_what_they_lack(rows, kept, tmp_path):
    (tmp_path / "t.csv").write_text("name,a,b,y\np,1,2,n\nq,,3,y\nr,4,5,\n")
    table = kept_rows(read_table(tmp_path / "t.csv"), rows, "y", ["a", "b"])
    assert "".join(table.frame["name"]) == kept


def test_labels_of_mixed_kind_are_text_and_words_that_look_like_numbers_stay_words(tmp_path):
    assert read_table(csv_file(tmp_path, "y\n1\nb\n")).labels("y").tolist() == ["1", "b"]
    pd.DataFrame({"y": ["1", "2"]}).to_parquet(tmp_path / "data.parquet")
    assert read_table(tmp_path / "data.parquet").labels("y").tolist() == ["1", "2"]


@pytest.mark.parametrize(
    ("lines", "said"),
    [
        (["1,a", "g,hh", "2,b", "g,h", "3,a"], "line 5 with the header again"),
        (["# p", "1,a", "# p", "2,b"], "lines 2, 4 of comment"),
        (["1,a", "# p", "# p", "# p", "3,a"], "lines 3 to 5 of comment"),
        (["1,a", "# p", "# p", "3,a", "# p"], "lines 3, 4, 6 of comment"),
        (["1,a", "% p"] * 8, "lines 3, 5, 7, 9, 11, 13 and 2 more of comment"),
        (["1,a", "2,b", "", "End of data"], "'End of data' after the last row"),
        (["1,a", "2,b", "-----", "End", "Sum up"], "'-----' after the last row; 'End' after the last row; 'Sum up'"),
    ],
)
def test_lines_that_hold_no_row_are_left_out_and_named(tmp_path, lines, said):
    table = read_table(csv_file(tmp_path, "\n".join(["g,h", *lines, ""])))
    assert [note.startswith(f"no rows and left out: {said}") for note in table.notes] == [True]
    assert len(table.frame) == sum("," in line and line != "g,h" for line in lines)


@pytest.mark.parametrize("tail", [*product(["", "  ", "-----", "The end"], repeat=2)])
def test_whatever_stands_below_the_last_row_no_row_is_lost(tmp_path, tail):
    table = read_table(csv_file(tmp_path, "\n".join(["g,h", "1,a", "2,b", *tail, ""])))
    assert table.frame["g"].tolist() == [1, 2]
    words = [line for line in tail if line.strip()]
    assert all(f"{word!r} after the last row" in table.notes[0] for word in words)
    assert len(table.notes) == bool(words)


def test_words_under_units_are_no_row_where_all_columns_are_of_numbers(tmp_path):
    rows = "".join(f"{k}\t{k}\n" for k in range(9))
    assert len(read_table(csv_file(tmp_path, f"Time\tg1\nms\tum/m\n\tSensor A\n{rows}")).frame) == 9


@pytest.mark.parametrize("rows", ["m,,\nf,6,1.7\n", "real,,\nfake,1,2\n", "fake,1,2\nreal,,\n"])
def test_a_class_that_is_a_unit_or_a_type_stands_in_a_row(tmp_path, rows):
    assert len(read_table(csv_file(tmp_path, f"kind,a,b\n{rows}fake,3,4\nreal,5,6\n")).frame) == 4


def test_words_in_cells_above_a_header_are_no_table(tmp_path):
    table = read_table(csv_file(tmp_path, "note,see,below\nnote,see,beside\nnote,or,ask\nx,y\n1,a\n2,b\n3,c\n"))
    assert (table.columns, len(table.frame)) == (("x", "y"), 3)


@pytest.mark.parametrize("name", ["iris.data", "iris.txt", "iris"])
def test_another_ending_leaves_it_to_the_content(tmp_path, name):
    path = tmp_path / name
    path.write_text("x\ty\n1\ta\n")
    assert read_table(path).columns == ("x", "y")
    pd.DataFrame({"z": [1.0]}).to_parquet(path)
    assert read_table(path).columns == ("z",)


@pytest.mark.parametrize(
    "text",
    [
        "true,b,a\nb,0,1\na,10,0\n",
        ",a,b\na,0,10\nb,1,0\n",
        '"a","b"\n"a",0,10\n"b",1,0\n',
        "true , a, b\nb , 1, 0\na , 0, 10\n",
    ],
    ids=["in another order", "pandas", "R", "blanks"],
)
def test_costs_are_read_in_any_order(tmp_path, text):
    assert read_costs(csv_file(tmp_path, text), ["a", "b"]).tolist() == [[0, 10], [1, 0]]


WRITTEN = """y,money,share,day,mixed
a,"$1,000.50",5%,2025-03-04,$5
b,$3,12.5%,2025-03-05,7
"""


def test_targets_weights_and_costs_are_read_as_they_are_written(tmp_path):
    table = read_table(csv_file(tmp_path, WRITTEN))
    for purpose in ("target", "weight"):
        assert table.numbers(["money", "share"], purpose).tolist() == [[1000.5, 5], [3, 12.5]]
    assert np.diff(table.numbers(["day"], "target")[:, 0]) == [1.0]
    with pytest.raises(DataError, match="'2025-03-04' is no number, and a weight holds numbers only"):
        table.numbers(["day"], "weight")
    with pytest.raises(DataError, match=r"column 'mixed' holds numbers with different signs \(\$ and none\)"):
        table.numbers(["mixed"], "target")
    path = csv_file(tmp_path, 'true,a,b\na,$0,$5\nb,"$1,000.50",$0\n')
    assert read_costs(path, ["a", "b"]).tolist() == [[0, 5], [1000.5, 0]]
    path = csv_file(tmp_path, 'sensor,cost\na,"$1,200"\n')
    assert read_sensors(path, ["a"]).cost == {"a": 1200}


@pytest.mark.parametrize(
    ("text", "of_feature", "cost"),
    [
        ("sensor,cost\nb,2\na,1\nunused,9\n", ("a", "b"), {"a": 1, "b": 2}),
        ("feature,sensor,cost\na,left,1\nb,left,1\nc,right,2\n", ("left", "left", "right"), {"left": 1, "right": 2}),
    ],
)
def test_sensors_give_one_feature_or_several(tmp_path, text, of_feature, cost):
    sensors = read_sensors(csv_file(tmp_path, text), ["a", "b", "c"][: len(of_feature)])
    assert (sensors.of_feature, sensors.cost) == (of_feature, cost)


@pytest.mark.parametrize(
    "content", [b"x,y\n1,a\n2,b\n", gzip.compress(b"x,y\n1,a\n2,b\n", mtime=0), b"x\ty\n1\ta\n2\tb\n"]
)
def test_standard_input_is_a_table(monkeypatch, content):
    monkeypatch.setattr("sys.stdin", io.TextIOWrapper(io.BytesIO(content)))
    table = read_table("-")
    assert table.numbers(["x"]).tolist() == [[1], [2]]
    assert table.place(1, "y") == "standard input, line 3, column 'y'"


def test_standard_input_may_be_parquet_and_must_not_be_empty(monkeypatch):
    buffer = io.BytesIO()
    pd.DataFrame({"x": [1, 2]}).to_parquet(buffer)
    monkeypatch.setattr("sys.stdin", io.TextIOWrapper(io.BytesIO(buffer.getvalue())))
    assert read_table("-").numbers(["x"]).tolist() == [[1], [2]]
    monkeypatch.setattr("sys.stdin", io.TextIOWrapper(io.BytesIO(b"\n")))
    with pytest.raises(DataError, match="standard input is empty"):
        read_table("-")


def test_parquet_may_be_packed(tmp_path):
    buffer = io.BytesIO()
    pd.DataFrame({"x": [1, 2]}).to_parquet(buffer)
    (tmp_path / "t.parquet.gz").write_bytes(gzip.compress(buffer.getvalue()))
    assert read_table(tmp_path / "t.parquet.gz").numbers(["x"]).tolist() == [[1], [2]]


@pytest.mark.parametrize(
    ("content", "sentence"),
    [
        (gzip.compress(b"x,y\n1,a\n", mtime=0)[:-9], "cannot be unpacked"),
        (b"\x1f\x8b\x08\x00aaaa", "cannot be unpacked"),
        (gzip.compress(b"x,y\n" + b"1,a\n" * 3000, mtime=0), "unpacks to more than 10000 bytes"),
        (gzip.compress(b"\n", mtime=0), "is empty"),
    ],
)
def test_a_packed_file_is_refused_when_broken_or_too_long_unpacked(tmp_path, monkeypatch, content, sentence):
    monkeypatch.setattr("octmip.input.files.MOST_BYTES", 10_000)
    (tmp_path / "t.csv.gz").write_bytes(content)
    with pytest.raises(DataError, match=sentence):
        read_table(tmp_path / "t.csv.gz")


def test_a_packed_table_may_unpack_to_64_mebibytes_or_to_200_times_its_size(tmp_path, monkeypatch):
    path = tmp_path / "t.csv.gz"
    path.write_bytes(gzip.compress(b"x,y\n" + b"1,a\n" * 20_000))
    assert len(open_source(path).content()) == 80_004
    monkeypatch.setattr("octmip.formats.table.source.SMALL", 80_003)
    with pytest.raises(DataError, match=r"unpacks to more than 80003 bytes \(.* times its size\); .*give it unpacked"):
        open_source(path).content()
    rng = np.random.default_rng(0)
    path.write_bytes(gzip.compress("\n".join(map(str, rng.random(20_000))).encode()))
    assert len(open_source(path).content()) > 80_003  # it unpacks to twice its size


@pytest.mark.parametrize(("first", "second", "is_refused"), [
    ("s,N,um/m\n", "s,kN,um/m\n", True), ("s,N,um/m\n", "s,N,um/m\n", False), ("", "s,kN,um/m\n", True),
    ("", "", False),
])  # fmt: skip
def test_a_header_that_stands_again_with_other_units_is_refused(first, second, is_refused, tmp_path):
    rows = ["".join(f"{at + k},{k},{2 * k}\n" for k in range(20)) for at in (0, 100)]
    (tmp_path / "two.csv").write_text(f"time,force,g1\n{first}{rows[0]}time,force,g1\n{second}{rows[1]}")
    if is_refused:
        said = r"two\.csv, line \d+: the header stands again with the units 's,kN,um/m'; expected "
        with pytest.raises(DataError, match=said):
            read_table(tmp_path / "two.csv")
    else:
        assert len(read_table(tmp_path / "two.csv").frame) == 40


def test_letters_under_a_header_that_stands_again_may_be_classes(tmp_path):
    (tmp_path / "two.csv").write_text("sex,grade\nm,A\ns,N\nm,N\nsex,grade\ns,A\nm,N\n")
    assert len(read_table(tmp_path / "two.csv").frame) == 5
