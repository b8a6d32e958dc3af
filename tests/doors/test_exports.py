"""Exports of random trees over columns of every type answer as `predict` does, and nothing where it refuses."""

import ctypes
import shutil
import sqlite3
import subprocess
from contextlib import closing

import numpy as np
import pandas as pd
import pytest

from benchmarks.cases.doors.sql_engines import outcome
from octmip import OptimalTreeClassifier
from octmip.errors import TreeError
from octmip.formats.columns import Columns
from octmip.formats.columns.cells import read_cells
from octmip.monitor.export import c_source, onnx_model, sql_expression
from octmip.trees.tree import HyperplaneSplit, Leaf, Split, ValueLeaf
from tests.oracles.export_runs import C_FLAGS
from tests.oracles.random_columns import ANSWERS, TYPES, answers_of, random_table, random_tree

STREAM = 61


@pytest.mark.parametrize("seed", range(2))
def test_sql_of_random_trees_is_predict_in_every_database_that_is_here(seed):
    line = outcome(seed, n_trees=10)
    assert "SQLite" in line["wrong"]
    assert set(line["wrong"].values()) == {0}, line


def cells_of(table, frame):
    """Return the codes and numbers of a table as C takes them (n, n_columns), and as ONNX takes each column."""
    codes, inputs = [], []
    for column in table.columns.columns:
        cells = read_cells(frame[column.name], column.form)
        if column.kind == "number":
            codes.append(cells.numbers)
            inputs.append(cells.numbers)
            continue
        words, code = column.words_of(cells), {word: float(k) for k, word in enumerate(column.values)}
        codes.append(np.array([code.get(word, -1.0) if word is not None else np.nan for word in words]))
        inputs.append(np.array(["" if word is None else word for word in words], dtype=object))
    return np.ascontiguousarray(np.column_stack(codes)), inputs


@pytest.mark.skipif(shutil.which("cc") is None, reason="no C compiler")
@pytest.mark.parametrize("seed", [0, 2])
def test_c_and_onnx_of_random_trees_are_predict(seed, tmp_path):
    runtime, parquet = pytest.importorskip("onnxruntime"), pytest.importorskip("pyarrow.parquet")
    rng = np.random.default_rng([STREAM, seed])
    kinds = [kind for kind in TYPES if seed or kind not in ("text", "category")]  # once all are numbers
    table = random_table(rng, tmp_path / "t.parquet", tuple(rng.choice(kinds, 4, replace=False)), doubled=seed == 2)
    codes, inputs = cells_of(table, parquet.read_table(table.path).to_pandas(ignore_metadata=True))
    names = [ANSWERS[k % len(ANSWERS)] if k % 5 else () for k in range(10)]
    trees = [random_tree(rng, table, len(classes), int(rng.integers(5))) for classes in names]
    asked = list(zip(trees, names, strict=True))
    sources = [c_source(tree, table.columns, n, name=f"tree_{k}") for k, (tree, n) in enumerate(asked)]
    (tmp_path / "t.c").write_text("".join(sources))
    flags = [*C_FLAGS, "-march=native", "-ffp-contract=fast", "-shared", "-fPIC"]
    subprocess.run(["cc", *flags, "-o", tmp_path / "t.so", tmp_path / "t.c"], check=True)
    library = ctypes.CDLL(str(tmp_path / "t.so"))
    for k, (tree, classes) in enumerate(asked):
        right = answers_of(tree, table, classes)
        predicted = library[f"tree_{k}"]
        is_text = bool(classes) and isinstance(classes[0], str)
        predicted.restype = ctypes.c_char_p if is_text else ctypes.c_double
        found = [predicted((ctypes.c_double * codes.shape[1])(*row)) for row in codes]
        assert [one.decode() if is_text else one for one in found] == right
        session = runtime.InferenceSession(onnx_model(tree, table.columns, classes).SerializeToString())
        own = {column.name: cells[:, None] for column, cells in zip(table.columns.columns, inputs, strict=True)}
        feed = {one.name: codes if one.name == "readings" else own[one.name] for one in session.get_inputs()}
        assert session.run(None, feed)[0].tolist() == right


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


def test_a_doubled_column_that_parts_no_rows_is_no_question():
    columns = Columns.learn(pd.DataFrame({"a": [1.0, None, 3.0]}), doubled=True)
    beyond = columns.columns[0].beyond
    for feature, threshold, side in ((0, beyond[0] - 1, "y"), (1, beyond[1], "x")):
        assert sql_expression(Split(feature, threshold, *ONE), columns, "xy").endswith(f"'{side}'")
    assert "IS NULL" in sql_expression(Split(0, beyond[0], *ONE), columns, "xy")


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
