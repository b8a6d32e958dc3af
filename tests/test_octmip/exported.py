"""What the exports of a tree answer in C, in SQLite and in ONNX; readings are called a, b, c ..."""

import importlib.util
import shutil
import sqlite3
import subprocess
from contextlib import closing
from ctypes import CDLL, c_double

import numpy as np
import pytest

from octmip.monitor.export import c_source, onnx_model, sql_expression
from octmip.trees.tree import leaves
from tests.oracles.export_runs import C_FLAGS


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
