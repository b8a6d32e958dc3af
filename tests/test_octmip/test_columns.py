"""Columns of any table as features: what is encoded and how, and that missing cells cost no optimality."""

import itertools
from contextlib import nullcontext
from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

from octmip.errors import DataError
from octmip.formats.columns import Columns, ColumnsError
from octmip.formats.columns.column import Column
from octmip.formats.tree_file import read_tree_file
from octmip.input.cells import text_by_number
from octmip.interfaces.cli import main
from octmip.interfaces.estimator import OptimalTreeClassifier
from octmip.trees.nodes.tree import Leaf, Split


def frame() -> pd.DataFrame:
    return pd.DataFrame(
        {
            "age": [40.0, None, 31.0, 60.0],
            "colour": ["red", "blue", "red", "green"],
            "sex": ["f", "m", "m", "f"],
            "load": [1, 2, 3, 4],
            "town": ["Delft", None, "Ulm", "Ulm"],
            "hot": [True, False, True, True],
        }
    )


def test_a_column_without_a_value_is_said_and_read_by_no_split_unless_missing_cells_are_refused():
    table = pd.DataFrame({"a": [1.0, 2.0, 3.0], "b": [None] * 3})
    columns = Columns.learn(table)
    assert [column.kind for column in columns.columns] == ["number", "empty"]
    assert "no split reads 1 column ('b'), without a value in any row" in columns.changes()
    for refused, how in ((table, "refuse"), (table[["b"]], "either-side")):
        with pytest.raises(ColumnsError, match="'b' has no value in any row; leave it out"):
            Columns.learn(refused, missing=how)


def test_text_becomes_questions_and_a_column_with_missing_readings_stays_one_feature():
    columns = Columns.learn(frame())
    assert columns.feature_names == (
        "age",
        "colour is blue",
        "colour is green",
        "colour is red",
        "sex is m",
        "load",
        "town is Delft",
        "town is Ulm",
        "town is missing",
        "hot",
    )
    encoded = columns.encode(frame())
    np.testing.assert_array_equal(encoded[:, 0], [40, np.nan, 31, 60])
    assert encoded[:, 3].tolist() == [1, 0, 1, 0]
    assert encoded[:, 8].tolist() == [0, 1, 0, 0]
    assert columns.column_of_feature[:2] == ("age", "colour")
    assert columns.lack_numbers
    assert not columns.is_plain
    assert columns.changes() == (
        "text in 3 columns ('colour', 'sex', 'town') became 7 yes/no questions",
        "cells are missing in 2 columns ('age', 'town'); a split sends them to whichever side is better",
    )
    with pytest.raises(DataError, match=r"missing in 'a', 'b', 'c', 'd', 'e' and 2 more; a hyperplane .*; fill them"):
        Columns.learn(pd.DataFrame({name: [1, None] for name in "abcdefg"})).refuse_missing_in_sums("fill them")


@pytest.mark.parametrize(
    ("feature", "threshold", "missing", "words"),
    [
        (0, 35.5, "left", "age <= 35.5 or missing"),
        (0, None, "left", "age is missing"),
        (0, 35.5, "right", "age <= 35.5"),
        (0, None, "right", "age is not missing"),
        (1, 0.5, "left", "colour is not blue"),
        (4, 0.5, "right", "sex is f"),
        (5, 2.5, "left", "load <= 2.5 or missing"),
        (5, 2.5, "right", "load <= 2.5"),
        (8, 0.5, "left", "town is not missing"),
    ],
)
def test_a_cut_is_said_in_words_that_hold_for_the_rows_it_sends_left(feature, threshold, missing, words):
    split = Split(feature, threshold, Leaf(0), Leaf(1), missing=missing)
    assert Columns.learn(frame()).left_words(split) == words


@pytest.mark.parametrize(
    ("feature", "threshold", "words"),
    [
        (0, 35.5, "age <= 35.5 or missing"),
        (0, 31.0, "age <= 31 or missing"),
        (0, 20.0, "age is missing"),
        (1, 35.5, "age <= 35.5"),
        (1, 60.0, "age is not missing"),
    ],
)
def test_the_two_features_of_older_files_are_said_in_the_same_words(feature, threshold, words):
    assert doubled().left_words(Split(feature, threshold, Leaf(0), Leaf(1))) == words


def doubled() -> Columns:
    """Return a column of numbers with missing readings as tree files up to version 2 have it."""
    return Columns(tuple(replace(column, is_doubled=True) for column in Columns.learn(frame()[["age"]]).columns))


def test_a_number_beyond_the_range_of_training_stays_on_its_side_of_every_cut_of_older_files():
    columns = doubled()
    later = columns.encode(pd.DataFrame({"age": [-100.0, 100.0, None, 33.0]}))
    assert columns.feature_names == ("age (missing below)", "age (missing above)")
    assert columns.columns[0].beyond == (31 - 29, 60 + 29)
    assert later.tolist() == [[31, -100], [100, 60], [2, 89], [33, 33]]


def test_numbers_may_be_missing_in_any_column_once_some_were_in_training():
    columns = Columns.learn(frame()[["age", "load"]])
    np.testing.assert_array_equal(columns.encode(pd.DataFrame({"age": [1], "load": [None]})), [[1, np.nan]])
    with pytest.raises(ColumnsError, match="had none in training"):
        Columns.learn(frame()[["load"]]).encode(pd.DataFrame({"load": [None, 2]}))


def test_texts_that_training_had_not_answer_no_and_are_named():
    columns = Columns.learn(frame()[["colour"]])
    later = pd.DataFrame({"colour": ["red", "pink", "pink"]})
    assert columns.encode(later).tolist() == [[0, 0, 1], [0, 0, 0], [0, 0, 0]]
    assert "'pink' (1 such values, 2 rows)" in columns.unseen(later)[0]
    assert columns.unseen(frame()) == ()


def test_numbers_among_texts_are_found_again_where_a_reader_took_them_for_numbers():
    columns = Columns.learn(pd.DataFrame({"code": ["1", "2", "a", "1"]}))
    assert columns.encode(pd.DataFrame({"code": [2, 1]})).tolist() == [[0, 1, 0], [1, 0, 0]]
    assert columns.encode(pd.DataFrame({"code": [2.0, 1.0]})).tolist() == [[0, 1, 0], [1, 0, 0]]


def test_words_for_missing_among_numbers_are_missing():
    columns = Columns.learn(pd.DataFrame({"x": ["1.5", "?", "NA", "0.1"]}))
    assert columns.columns[0].has_missing
    assert columns.columns[0].least == 0.1
    np.testing.assert_array_equal(columns.encode(pd.DataFrame({"x": ["1.5", "?"]})), [[1.5], [np.nan]])


def test_words_for_missing_alone_are_texts():
    words = pd.DataFrame({"w": pd.Series(["nan", "NA"] * 2, dtype=object)})
    assert Columns.learn(words).columns[0].values == ("NA", "nan")


def test_a_column_that_lost_its_values_is_a_constant_beside_the_others():
    table = pd.DataFrame({"lost": [np.nan] * 4, "load": [1.0, 2.0, 3.0, 4.0], "word": ["a", "b"] * 2})
    kinds = {column.name: column.kind for column in Columns.learn(table, of_part=True).columns}
    assert kinds == {"lost": "empty", "load": "number", "word": "values"}


def test_a_question_mark_among_texts_is_missing():
    columns = Columns.learn(pd.DataFrame({"x": ["a", "?", "b", "NA"]}))
    assert columns.feature_names == ("x is NA", "x is a", "x is b", "x is missing")


def test_a_number_stands_for_the_first_text_that_says_it():
    assert text_by_number(["1", "1.0", "x"], are_truths=False) == {1.0: "1", None: "x"}
    assert text_by_number(["TRUE", "true"], are_truths=True) == {1.0: "TRUE", 0.0: "false"}


def test_an_ordered_category_becomes_its_rank():
    kind = pd.CategoricalDtype(["low", "middle", "high"], ordered=True)
    table = pd.DataFrame({"size": pd.Series(["high", "low", "middle", None], dtype=kind)})
    columns = Columns.learn(table)
    np.testing.assert_array_equal(columns.encode(table), [[2], [0], [1], [np.nan]])
    split = Split(0, 1.5, Leaf(0), Leaf(1), missing="left")
    assert columns.left_words(split) == "size is low or middle or missing"
    grades = pd.DataFrame({"g": pd.Series([1, 3, 2], dtype=pd.CategoricalDtype([3, 2, 1], ordered=True))})
    np.testing.assert_array_equal(Columns.learn(grades).encode(grades), [[2], [0], [1]])
    letters = Columns.learn(pd.DataFrame({"x": list("abcde")}), categories="order")
    words = [letters.left_words(Split(0, at, Leaf(0), Leaf(1))) for at in (0.5, 2.0, 3.5)]
    assert words == ["x is a", "x is a or b or c", "x is d or before it"]
    assert letters.changes() == ("text in 1 column ('x') became its rank in the order of its values",)
    with pytest.raises(DataError, match="no place in the order"):
        columns.encode(pd.DataFrame({"size": ["tiny"]}), takes_missing=False)


def test_every_column_that_cannot_be_used_is_named_with_its_cure():
    table = pd.DataFrame(
        {
            "name": [f"row {k}" for k in range(40)],
            "day": ["03/04/2025"] * 40,
            "big": [2**60 + k for k in range(40)],
            "far": [np.inf] * 40,
            "odd": [[1]] * 40,
            "good": range(40),
        }
    )
    with pytest.raises(ColumnsError) as caught:
        Columns.learn(table)
    assert set(caught.value.reasons) == {"name", "day", "big", "far", "odd"}
    assert "5 of 6 columns" in str(caught.value)


@pytest.mark.parametrize(
    ("n_values", "n_rows", "sentence"),
    [(20, 20, ""), (21, 42, ""), (21, 41, "21 different texts in 41 rows"), (100, 200, ""), (101, 202, "at most 100")],
)
def test_texts_are_values_up_to_half_of_the_rows_and_a_hundred(n_values, n_rows, sentence):
    table = pd.DataFrame({"x": [f"t{k % n_values}" for k in range(n_rows)]})
    with pytest.raises(ColumnsError, match=sentence) if sentence else nullcontext():
        assert len(Columns.learn(table).feature_names) == n_values


def test_a_column_without_missing_readings_in_training_refuses_them_later():
    columns = Columns.learn(frame()[["load", "colour"]])
    with pytest.raises(ColumnsError) as caught:
        columns.encode(pd.DataFrame({"load": [1, None], "colour": ["red", None]}))
    assert set(caught.value.reasons) == {"load", "colour"}
    with pytest.raises(ColumnsError, match="not in the table"):
        columns.encode(pd.DataFrame({"load": [1]}))


def test_two_features_of_one_name_are_refused():
    table = pd.DataFrame({"a is b": [1, 2, 3], "a": ["b", "c", "d"]})
    with pytest.raises(DataError, match="'a is b'"):
        Columns.learn(table)


def test_every_permutation_of_rows_gives_the_same_columns():
    table = frame()
    wanted = Columns.learn(table)
    for order in itertools.islice(itertools.permutations(range(4)), 6):
        assert Columns.learn(table.iloc[list(order)]) == wanted


COLOURS = pd.DataFrame({"colour": ["red", "blue", "green", "blue", "grey", "red"]})
STATE = np.array(["hot", "hot", "cold", "hot", "cold", "hot"])


def test_every_set_without_the_first_value_is_a_feature_and_an_unknown_text_is_in_none():
    columns = Columns.learn(COLOURS, categories="subsets")
    assert columns.feature_names[:4] == (
        "colour in {green}",
        "colour in {grey}",
        "colour in {red}",
        "colour in {green, grey}",
    )
    assert len(columns.features) == 7
    assert set(columns.column_of_feature) == {"colour"}
    assert not columns.encode(pd.DataFrame({"colour": ["violet"]})).any()
    assert columns.unseen(pd.DataFrame({"colour": ["violet"]})) != ()
    assert columns.changes() == ("a split may ask for any set of the texts in 1 column ('colour')",)


def test_a_missing_cell_is_a_text_of_its_own():
    frame = pd.DataFrame({"c": ["a", "b", None, "b"]})
    columns = Columns.learn(frame, categories="subsets")
    assert columns.feature_names == ("c in {b}", "c in {missing}", "c in {b, missing}")
    assert columns.encode(frame)[:, 2].tolist() == [0, 1, 1, 1]


def test_a_split_is_written_by_the_shorter_set():
    columns = Columns.learn(COLOURS, categories="subsets")
    words = [columns.left_words(Split(j, 0.5, Leaf(0), Leaf(1))) for j in (0, 3, 6)]
    assert words == ["colour not in {green}", "colour in {blue, red}", "colour in {blue}"]
    assert set(columns.columns[0].questions().values()) == set(columns.feature_names)


def test_too_many_or_too_long_texts_are_refused():
    many = pd.DataFrame({"c": [f"t{k % 13}" for k in range(40)]})
    with pytest.raises(DataError, match="holds 13 different texts; expected at most 12, of which every set is tried"):
        Columns.learn(many, categories="subsets")
    with pytest.raises(DataError, match="shorten them"):
        Columns.learn(pd.DataFrame({"c": ["a" * 400, "b" * 400]}), categories="subsets")
    hostile = Column("c", "subsets", False, values=tuple(f"t{k}" for k in range(40))).to_json()
    with pytest.raises(DataError, match="sets are made of 12 texts at most"):
        Column.from_json(hostile)


def test_command_page_and_estimator_know_sets(tmp_path, capsys):
    table, tree = str(tmp_path / "t.csv"), str(tmp_path / "t.json")
    frame = pd.concat([COLOURS.assign(state=STATE)] * 4)
    frame.to_csv(table, index=False)
    words = ["--label", "state", "--depth", "1", "--categories", "subsets", "--out", tree]
    assert main(["solve", table, *words]) == 0
    assert "if colour in {blue, red}" in capsys.readouterr().out
    assert read_tree_file(tree).solution.objective == 0
    assert main(["certify", tree, table]) == 0
    page = str(tmp_path / "t.html")
    assert main(["report", tree, table, "--out", page]) == 0
    assert '"members": ["green", "grey"]' in (tmp_path / "t.html").read_text().replace('":[', '": [').replace(
        '","', '", "'
    )
    model = OptimalTreeClassifier(max_depth=1, categories="subsets").fit(frame[["colour"]], frame["state"])
    assert model.score(frame[["colour"]], frame["state"]) == 1
