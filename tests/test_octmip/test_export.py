"""Exports answer bit for bit whatever names, numbers and depth a tree has, and execute nothing but the tree."""

import importlib.util
import math
import shutil
import sqlite3
import subprocess
import sys
from contextlib import closing
from ctypes import CDLL, c_double

import numpy as np
import pytest

from octmip.errors import TreeError
from octmip.monitor.compiled import CompiledTree
from octmip.monitor.export import c_source, onnx_model, sql_expression
from octmip.trees.nodes.tree import HyperplaneSplit, Leaf, Split, leaves, predict
from tests.oracles.export_runs import C_FLAGS, EXACT, REFUSED, run_c, run_onnx, run_sql
from tests.oracles.hostile_names import hostile_names
from tests.oracles.report_runs import run_json, run_markdown, run_page, run_picture, run_text, tree_over


def _names(tree, readings):
    """Return names of the features and of the classes."""
    return "abcdefghij"[: readings.shape[1]], range(1 + max(leaf.label for leaf in leaves(tree)))


def c_labels(tree, readings, folder):
    """Return the labels (n,) of readings (n, n_features) by the compiled function, rounding as freely as C may."""
    (folder / "tree.c").write_text(c_source(tree, *_names(tree, readings)))
    flags = [*C_FLAGS, "-march=native", "-ffp-contract=fast", "-shared", "-fPIC"]
    subprocess.run(["cc", *flags, "-o", folder / "tree.so", folder / "tree.c"], check=True, capture_output=True)
    label = CDLL(str(folder / "tree.so")).octmip_predict
    label.restype = c_double
    readings = np.ascontiguousarray(readings)
    start, size = readings.ctypes.data, 8 * readings.shape[1]
    rows = ((c_double * readings.shape[1]).from_address(start + size * k) for k in range(len(readings)))
    return _labels(label(row) for row in rows)


def _labels(answers):
    """Return answers as labels, -1 where there is none."""
    return [-1 if answer is None or answer != answer else int(answer) for answer in answers]


def sql_labels(tree, readings, folder):
    """Return the labels (n,) of readings (n, n_features) by a query of SQLite."""
    names, classes = _names(tree, readings)
    with closing(sqlite3.connect(folder / "base")) as base:
        base.execute(f"CREATE TABLE readings ({', '.join(f'{name} DOUBLE PRECISION' for name in names)}, n INTEGER)")
        rows = [(*row, k) for k, row in enumerate(readings.tolist())]
        base.executemany(f"INSERT INTO readings VALUES ({', '.join('?' * (len(names) + 1))})", rows)
        query = f"SELECT {sql_expression(tree, names, classes)} FROM readings ORDER BY n"
        return _labels(answer for (answer,) in base.execute(query))


def onnx_labels(tree, readings, folder):
    """Return the labels (n,) of readings (n, n_features) by the ONNX runtime."""
    import onnx
    import onnxruntime as runtime

    options = runtime.SessionOptions()
    options.graph_optimization_level = runtime.GraphOptimizationLevel.ORT_DISABLE_ALL
    options.intra_op_num_threads = 1
    model = onnx_model(tree, *_names(tree, readings))
    onnx.checker.check_model(model)
    session = runtime.InferenceSession(model.SerializeToString(), options)
    return _labels(session.run(None, {"readings": readings})[0].tolist())


EXPORTS = [
    pytest.param(c_labels, marks=pytest.mark.skipif(shutil.which("cc") is None, reason="no C compiler"), id="c"),
    pytest.param(sql_labels, id="sql"),
    pytest.param(
        onnx_labels,
        marks=pytest.mark.skipif(importlib.util.find_spec("onnxruntime") is None, reason="no onnxruntime"),
        id="onnx",
    ),
]


NAMES = [name for _, name in hostile_names(60)]
# Hostile names: 500 of them go through `python -m benchmarks.run exports`


def test_sql_executes_the_tree_alone_for_any_name():
    assert "DROP TABLE" in "".join(NAMES)
    assert set(run_sql(NAMES)) <= {EXACT, REFUSED}
    refused = [name for name, outcome in zip(NAMES, run_sql(NAMES), strict=True) if outcome == REFUSED]
    assert refused == [name for name in NAMES if "\\" in name or cannot_be_text(name)]


def cannot_be_text(name):
    return "\0" in name or any("\ud800" <= c <= "\udfff" for c in name)


@pytest.mark.skipif(shutil.which("cc") is None, reason="no C compiler")
def test_c_compiles_without_a_warning_and_answers_for_any_name():
    names = [*NAMES, "*/ #error /*", "a??/\n", "*/", "*??/\n/"]
    is_refused = [cannot_be_text(name) or len(name.encode()) > 4095 for name in names]
    assert run_c(names) == [REFUSED if refused else EXACT for refused in is_refused]


def test_onnx_answers_and_keeps_every_name():
    pytest.importorskip("onnxruntime")
    assert set(run_onnx(NAMES[:40])) == {EXACT, REFUSED}


@pytest.mark.parametrize("run", [run_text, run_json, run_markdown])
def test_every_name_can_be_read_and_none_acts(run):
    assert set(run(NAMES)) == {EXACT}


def test_pictures_have_no_formula_and_no_missing_glyph():
    assert set(run_picture(NAMES[::4])) == {EXACT}


def test_a_page_shows_every_name_and_runs_none(browser, tmp_path):
    assert set(run_page(NAMES, browser, tmp_path)) == {EXACT}


@pytest.mark.parametrize("name", ["a\0b", "\ud800"])
def test_a_column_that_no_database_takes_is_refused(name):
    with pytest.raises(TreeError, match="for the name of a column; rename"):
        sql_expression(Split(0, 0.5, Leaf(0), Leaf(1)), [name], "xy")
    assert sql_expression(Split(0, 0.5, Leaf(0), Leaf(1)), ["a", name], "xy")  # it is not read


def test_a_missing_column_is_an_error_in_sqlite_when_the_table_is_named():
    text = sql_expression(Split(0, 0.5, Leaf(0), Leaf(1)), ["a"], "xy", table='re"adings')
    with sqlite3.connect(":memory:") as base:
        base.execute('CREATE TABLE "re""adings" (b)')
        with pytest.raises(sqlite3.OperationalError, match="no such column"):
            base.execute(f'SELECT {text} FROM "re""adings"')
    base.close()


@pytest.mark.parametrize("export", [c_source, sql_expression, onnx_model])
def test_names_must_cover_the_tree(export):
    with pytest.raises(TreeError, match="reads feature 1 but feature_names has 1 entries"):
        export(Split(1, 0.5, Leaf(0), Leaf(1)), ["a"], ["x", "y"])
    with pytest.raises(TreeError, match="predicts class 1 but class_names has 1 entries"):
        export(Split(0, 0.5, Leaf(0), Leaf(1)), ["a"], ["x"])
    tree = Leaf(0)
    for _ in range(3000):
        tree = Split(0, 0.5, Leaf(0), tree)
    with pytest.raises(TreeError, match="more than 30 levels"):
        export(tree, ["a"], ["x"])


@pytest.mark.parametrize("name", ["int", "while", "class", "2x", "a b", "", "a;"])
def test_a_function_is_not_called_by_a_word_of_c(name):
    with pytest.raises(TreeError, match="is no C name"):
        c_source(Leaf(0), ["a"], ["x"], name=name)


EXTREMES = [5e-324, 2.2250738585072014e-308, 1e-300, 0.1, 2.0**53 + 2, 1e22, 2.0**63, 1e300, 1e308, sys.float_info.max]
THRESHOLDS = sorted([*EXTREMES, *(-t for t in EXTREMES)])


def chain(thresholds, is_left=False):
    """Return a tree with one split a level, a label of its own for every interval of feature 0."""
    tree = Leaf(len(thresholds))
    if is_left:
        for k, threshold in enumerate(sorted(thresholds)):
            tree = Split(0, threshold, tree if k else Leaf(99), Leaf(k))
        return tree
    for k, threshold in reversed(list(enumerate(thresholds))):
        tree = Split(0, threshold, Leaf(k), tree)
    return tree


def extreme_tree():
    sums = [HyperplaneSplit((0, 1), (1e308, -5e-324), 1e300, Leaf(0), Leaf(1))]
    sums += [HyperplaneSplit((0, 1), (-1.7976931348623157e308, 2.0**-1074), -0.0, sums[0], Leaf(2))]
    sums += [HyperplaneSplit((0, 1), (5e-324, 0.1), 5e-324, sums[1], Leaf(3))]
    return Split(1, -0.0, sums[2], Split(0, 2**53 + 1, sums[1], Leaf(4)))  # the threshold is a whole number of Python


def broad_tree():
    tree = tree_over(1023)
    rng = np.random.default_rng(0)

    def drawn(node):
        if isinstance(node, Leaf):
            return node
        return Split(node.feature % 2, float(rng.normal()), drawn(node.left), drawn(node.right))

    return drawn(tree)


SHAPES = {
    "a leaf": Leaf(2),
    "chain to the right": chain(sorted([*THRESHOLDS, *np.linspace(-3, 3, 10)])),
    "chain to the left": chain(sorted([*THRESHOLDS, *np.linspace(-3, 3, 10)]), is_left=True),
    "extremes": extreme_tree(),
    "1,024 leaves": broad_tree(),
}


@pytest.fixture(scope="module", params=SHAPES)
def shape(request):
    tree = SHAPES[request.param]
    rng = np.random.default_rng(1)
    beside = [math.nextafter(t, side) for t in (*THRESHOLDS, 0.0, -0.0) for side in (-math.inf, t, math.inf)]
    values = np.array([*beside, -0.0, np.inf, -np.inf, 2.0**53, *rng.normal(size=20)])
    readings = rng.choice(values, (300, 2))
    with np.errstate(over="ignore", invalid="ignore"):
        answers = CompiledTree(tree, ("a", "b")).labels(readings)
    return tree, readings, answers.tolist()


@pytest.mark.parametrize("export", EXPORTS)
@pytest.mark.parametrize("missing", [None, "left", "right"])
def test_infinite_readings_of_a_hyperplane_end_where_the_tree_ends(missing, export, tmp_path_factory):
    below = HyperplaneSplit((0, 1), (1.0, 1.0), 3.0, Leaf(0), Leaf(2), missing=missing)
    asks = Split(1, None, below, Leaf(3), missing=missing) if missing else below
    tree = HyperplaneSplit((0, 1), (1.0, -2.0), 0.5, Leaf(1), asks, missing=missing)
    values = [math.inf, -math.inf, 0.25, 2.0, *([math.nan] if missing else [])]
    readings = np.array([(a, b) for a in values for b in values])
    deep = tree
    for _ in range(12):  # written flat in SQL
        deep = Split(0, -1e308, Leaf(0), deep, missing=missing and "right")
    for k, one in enumerate((tree, deep)):
        assert list(export(one, readings, tmp_path_factory.mktemp(str(k)))) == predict(one, readings).tolist()
        compiled = CompiledTree(one, ("a", "b"))
        with np.errstate(invalid="ignore"):
            assert compiled.labels(readings).tolist() == predict(one, readings).tolist()
            assert [compiled.label(row) for row in readings] == predict(one, readings).tolist()


@pytest.mark.parametrize("export", EXPORTS)
def test_an_export_holds_any_shape_and_number(shape, export, tmp_path):
    tree, readings, answers = shape
    assert list(export(tree, readings, tmp_path)) == answers


def test_a_sum_of_hundreds_of_features_fits_into_sqlite_and_one_too_long_is_refused():
    tree = HyperplaneSplit(tuple(range(900)), (0.1,) * 900, 1.0, Leaf(0), Leaf(1))
    names = [f"x{j}" for j in range(901)]
    with sqlite3.connect(":memory:") as base:
        base.execute(f"CREATE TABLE readings ({', '.join(names)})")
        assert base.execute(f"SELECT {sql_expression(tree, names, 'xy')} FROM readings").fetchall() == []
    base.close()
    with pytest.raises(TreeError, match="adds 901 features; expected at most 900"):
        sql_expression(HyperplaneSplit(tuple(range(901)), (0.1,) * 901, 1.0, Leaf(0), Leaf(1)), names, "xy")
