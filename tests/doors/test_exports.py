"""Exports of random trees over columns of every type answer as `predict` does, and nothing where it refuses."""

import sqlite3
from contextlib import closing

import numpy as np
import pandas as pd
import pytest

from benchmarks.cases.doors.sql_engines import outcome
from octmip import OptimalTreeClassifier
from octmip.errors import TreeError
from octmip.formats.columns import Columns
from octmip.monitor.export import c_source, onnx_model, sql_expression
from octmip.trees.nodes.tree import HyperplaneSplit, Leaf, Split, ValueLeaf


@pytest.mark.parametrize("seed", range(2))
def test_sql_of_random_trees_is_predict_in_every_database_that_is_here(seed):
    line = outcome(seed, n_trees=10)
    assert "SQLite" in line["wrong"]
    assert set(line["wrong"].values()) == {0}, line


TRAINED = pd.DataFrame({"text": ["a", "b", "c"], "number": [1.0, 2.0, 3.0], "flag": [True, False, True]})
DAYS = pd.DataFrame({"day": pd.to_datetime(["2024-03-01", "2024-03-02", "2024-03-04"])})
RANKED = Columns.learn(TRAINED[["text"]], categories="order")
ONE = Leaf(0), Leaf(1)


@pytest.mark.parametrize(
    ("columns", "tree", "cells", "answers"),
    [
        (Columns.learn(TRAINED), Split(0, 0.5, *ONE), ["a", "b", "z", None, "?", "A"], [9, 8, 8, None, None, 8]),
        (RANKED, Split(0, 0.5, *ONE), ["a", "c", "z", None], [8, 9, None, None]),
        (Columns.learn(TRAINED[["number"]]), Split(0, 1.5, *ONE), [1, 2.5, None, "", "nan"], [8, 9, None, None, None]),
        (
            Columns.learn(TRAINED[["flag"]]),
            Split(0, 0.5, *ONE),
            [0, "true", "False", None, "no"],
            [8, 9, 8, None, None],
        ),
        (
            Columns.learn(DAYS),
            Split(0, 19783.5, *ONE),
            [
                "2024-03-01",
                "2024-03-01T12:00:00",
                "2024-03-01 12:00:00.000001",
                "2024-03-01T12:00Z",
                "2024-03-02 00:00+00",
            ],
            [8, 8, 9, 8, 9],
        ),
        (
            Columns.learn(pd.DataFrame({"strain": [1.5, 2.5]})),
            Split(0, 2.0, *ONE),
            ["NA", "n/a", "None", "null", "-", "", None],
            [None] * 7,
        ),
        (
            Columns.learn(DAYS),
            Split(0, 19783.5, *ONE),
            ["2024-03-01 12:00+02:00", "2024-03-01 12:00-05", "20240301", "1709294400", "2024-03-01T120000", None],
            [None] * 6,
        ),
    ],
)
def test_a_cell_that_predict_refuses_has_no_answer_in_sql(columns, tree, cells, answers):
    named = columns.columns[0].name
    with closing(sqlite3.connect(":memory:")) as base:
        base.execute(f'CREATE TABLE t ("{named}")')
        base.executemany("INSERT INTO t VALUES (?)", [(cell,) for cell in cells])
        text = sql_expression(tree, columns, [8, 9])
        assert [row[0] for row in base.execute(f"SELECT {text} FROM t ORDER BY rowid")] == answers


@pytest.mark.parametrize(
    ("tree", "columns", "words"),
    [
        (HyperplaneSplit((0,), (1.0,), 3.0, *ONE), Columns.learn(DAYS), "adds the days of day"),
        (ValueLeaf(1.0, (0,), (2.0,)), Columns.learn(DAYS), "adds the days of day"),
        (Split(0, 1.5, *ONE), Columns.learn(pd.DataFrame({"d": pd.to_timedelta([1, 2], unit="D")})), "durations"),
        (Split(0, 1e9, *ONE), Columns.learn(DAYS), "expected years 0 to 9999"),
    ],
)
def test_what_sql_cannot_say_in_every_database_is_refused_and_c_says_it(tree, columns, words):
    with pytest.raises(TreeError, match=words):
        sql_expression(tree, columns, ["x", "y"])
    assert "reading[0]" in c_source(tree, columns, ["x", "y"])


@pytest.mark.parametrize(
    ("classes", "words"),
    [([], "predicts class 1 but class_names has 0"), ([1, "a"], "expected texts"), ([0.5, np.nan], "0.5, nan")],
)
def test_classes_are_needed_and_of_one_kind(classes, words):
    for export in (sql_expression, c_source, onnx_model):
        with pytest.raises(TreeError, match=words):
            export(Split(0, 0.5, *ONE), ["a"], classes)


def test_names_of_features_speak_of_the_columns_and_classes_without_names_are_their_indices():
    table = pd.DataFrame({"machine": ["press", "pump", "press", "pump"] * 5})
    tree = OptimalTreeClassifier(max_depth=1).fit(table, ["bad", "good"] * 10)
    with sqlite3.connect(":memory:") as base:
        table.to_sql("readings", base)
        for names, answers in ((None, [0, 1]), (tree.classes_, ["bad", "good"])):
            text = sql_expression(tree.tree_, tree.columns_.feature_names, names)
            heads = [text, source := c_source(tree.tree_, tree.columns_.feature_names, names)]
            assert [("the index of a class" in head) for head in heads] == [names is None] * 2
            assert "It is given reading[0], and reads:" in source
            assert [one for (one,) in base.execute(f"SELECT {text} FROM readings")] == answers * 10
        assert base.execute('SELECT "no such" FROM readings').fetchone() == ("no such",)  # SQLite's own, in silence
        with pytest.raises(sqlite3.OperationalError, match="no such column"):
            base.execute('SELECT readings."no such" FROM readings')
