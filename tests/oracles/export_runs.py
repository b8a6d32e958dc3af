"""Every export and report, made with hostile names and then parsed and run by the machine that it is for.

Each function takes names and returns for each what came of it: EXACT (parsed, nothing else executed, every answer bit
for bit or every name to be read), REFUSED (one sentence), or what is wrong.
"""

import json
import sqlite3
import subprocess
import tempfile
from collections.abc import Callable, Sequence
from ctypes import CDLL, POINTER, c_char_p, c_double
from pathlib import Path

import numpy as np

from femlib.arrays import FloatArray
from octmip.errors import TreeError
from octmip.monitor.export import c_source, onnx_model, sql_expression
from octmip.trees.tree import HyperplaneSplit, Leaf, Split, predict

EXACT, REFUSED = "exact", "refused"
C_FLAGS = ("-std=c99", "-O1", "-Wall", "-Wextra", "-Wconversion", "-Werror", "-pedantic")
TREE = Split(0, 0.1, Leaf(0), HyperplaneSplit((0, 1), (1 / 3, -0.7), 0.2, Leaf(1), Split(1, -1e-5, Leaf(2), Leaf(0))))
PLAIN = "plain"


def readings() -> FloatArray:
    """Return readings on the thresholds of `TREE`, one unit in the last place beside them, and anywhere, (n, 2)."""
    rng = np.random.default_rng(0)
    values = [np.nextafter(t, side) for t in (0.1, -1e-5, 0.2) for side in (-9.0, t, 9.0)]
    return np.concatenate([rng.choice(values, (10, 2)), rng.normal(size=(10, 2))])


def run_sql(names: Sequence[str]) -> list[str]:
    """Execute the expression as a script in SQLite, beside a table that must survive."""
    base = sqlite3.connect(":memory:", isolation_level=None)
    base.execute("CREATE TABLE secret (a)")
    base.execute("INSERT INTO secret VALUES (1)")
    found = [_sql(base, name) for name in names]
    base.close()
    return found


def _sql(base: sqlite3.Connection, name: str) -> str:
    try:
        text = sql_expression(TREE, (name, "octmip_2"), (name, "b", "c"))
    except TreeError:
        return REFUSED
    column = '"' + name.replace('"', '""') + '"'
    base.execute("DROP TABLE IF EXISTS readings")
    base.execute(f"CREATE TABLE readings ({column} DOUBLE PRECISION, octmip_2 DOUBLE PRECISION, octmip_n INTEGER)")
    rows = readings()
    base.executemany("INSERT INTO readings VALUES (?, ?, ?)", [(*row, k) for k, row in enumerate(rows.tolist())])
    statements: list[str] = []
    base.set_trace_callback(statements.append)
    try:
        base.executescript(f"CREATE TEMP TABLE answer AS SELECT octmip_n AS n, {text} AS label FROM readings")
    except sqlite3.Error as error:
        return f"SQLite: {error}"
    finally:
        base.set_trace_callback(None)
        answers = base.execute("SELECT label FROM answer ORDER BY n").fetchall() if _has(base, "answer") else []
        base.execute("DROP TABLE IF EXISTS answer")
    if not _has(base, "secret") or base.execute("SELECT * FROM secret").fetchall() != [(1,)]:
        base.execute("CREATE TABLE IF NOT EXISTS secret (a)")
        return "the canary is dead"
    if sum(not statement.startswith("--") for statement in statements) != 1:
        return f"{len(statements)} statements ran"
    return EXACT if [answer for (answer,) in answers] == _right(name) else "other answers"


def _right(name: str) -> list[str]:
    """Return what the tree answers for `readings`: its first class has the name."""
    classes = (name, "b", "c")
    return [classes[label] for label in predict(TREE, readings()).tolist()]


def _has(base: sqlite3.Connection, table: str) -> bool:
    query = "SELECT name FROM sqlite_master WHERE name = ? UNION SELECT name FROM sqlite_temp_master WHERE name = ?"
    return bool(base.execute(query, (table, table)).fetchall())


def run_c(names: Sequence[str]) -> list[str]:
    """Compile the functions of all names as one unit, every warning an error, and call each."""
    sources = [_c_source(name, f"predict_{k}") for k, name in enumerate(names)]
    with tempfile.TemporaryDirectory() as folder:
        library = _compiled("".join(sources), Path(folder))
        if isinstance(library, str):
            return [library] * len(names)
        found = []
        for k, (name, source) in enumerate(zip(names, sources, strict=True)):
            is_right = bool(source) and _c_answers(library, f"predict_{k}") == [one.encode() for one in _right(name)]
            found.append(EXACT if is_right else "other answers" if source else REFUSED)
        return found


def _c_source(name: str, function: str) -> str:
    """Return the source of a tree whose feature and class have a name, "" where it is refused."""
    try:
        return c_source(TREE, (name, PLAIN), (name, "b", "c"), name=function)
    except TreeError:
        return ""


def _compiled(source: str, folder: Path) -> CDLL | str:
    (folder / "trees.c").write_text(source)
    command = ["cc", *C_FLAGS, "-shared", "-fPIC", "-o", str(folder / "trees.so"), str(folder / "trees.c")]
    done = subprocess.run(command, capture_output=True, text=True)
    return CDLL(str(folder / "trees.so")) if done.returncode == 0 else f"cc: {done.stderr.splitlines()[0]}"


def _c_answers(library: CDLL, function: str) -> list[bytes]:
    predicted = library[function]
    predicted.argtypes, predicted.restype = [POINTER(c_double)], c_char_p
    return [predicted((c_double * 2)(*row)) for row in readings().tolist()]


def run_onnx(names: Sequence[str]) -> list[str]:
    """Check the model, run it, and read the names back out of its metadata."""
    import onnx
    import onnxruntime

    options = onnxruntime.SessionOptions()
    options.intra_op_num_threads = 1
    options.graph_optimization_level = onnxruntime.GraphOptimizationLevel.ORT_DISABLE_ALL
    found = []
    for name in names:
        try:
            model = onnx_model(TREE, (name, PLAIN), (name, "b", "c"))
        except TreeError:
            found.append(REFUSED)
            continue
        onnx.checker.check_model(model)
        session = onnxruntime.InferenceSession(model.SerializeToString(), options, providers=["CPUExecutionProvider"])
        answers = session.run(None, {"readings": readings()})[0]
        held = {key: json.loads(value) for key, value in session.get_modelmeta().custom_metadata_map.items()}
        is_named = held["readings"][0]["name"] == name and held["answers"] == [name, "b", "c"]
        found.append(EXACT if answers.tolist() == _right(name) and is_named else "other answers or names")
    return found


EXPORTS: dict[str, Callable[[Sequence[str]], list[str]]] = {"SQL": run_sql, "C": run_c, "ONNX": run_onnx}
