"""What leaves as code: SQL over a table that a database reads by itself, C, ONNX, and a monitor on raw readings."""

import ctypes
import importlib
import json
import subprocess
from collections.abc import Callable
from datetime import UTC, date, datetime, timedelta
from decimal import Decimal
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from octmip.errors import DataError
from tests.doors.row import Refused, Row, command
from tests.oracles.sql_engines import ENGINES, ROW, same

NAN = float("nan")
NEGATIVE_NAN = float(np.copysign(NAN, -1.0))
NOON = datetime(2024, 3, 1, 12)


def _times(step: timedelta, zone: Any = None) -> list[datetime]:
    return [(NOON + k * step).replace(tzinfo=zone) for k in range(4)]


CELLS: dict[str, tuple[str, list[Any], list[Any]]] = {
    "double with NaN of both signs": ("double", [-1e300, 0.1, 0.1 + 2**-55, 1e308], [NAN, NEGATIVE_NAN, None]),
    "double of subnormals": ("double", [-5e-324, 0.0, 5e-324, 1e-310], [NAN]),
    "float": ("float", [0.1, 0.2, 0.3, 3e38], [NAN, None]),
    "int8": ("int8", [-128, -1, 0, 127], [None]),
    "int64": ("int64", [-(2**53), 0, 1, 2**53], []),
    "uint8": ("uint8", [0, 1, 2, 255], [None]),
    "uint16": ("uint16", [0, 3, 9, 65535], []),
    "uint32": ("uint32", [0, 1, 2, 2**32 - 1], [None]),
    "uint64": ("uint64", [0, 1, 2, 2**53], [None]),
    "Boolean": ("bool", [False, False, True, True], [None]),
    "decimal": ("decimal128(9, 2)", [Decimal("-0.10"), Decimal("0.10"), Decimal("0.11"), Decimal("7.00")], [None]),
    "text": ("string", ["it's", "Ä", 'a "b"', "-- x"], [None]),
    "category": ("dictionary", ["it's", "it's", 'a "b"', 'a "b"'], [None]),
    "numbers as text": ("string", ["-1", "0.5", "1e3", "2000"], ["?", "n/a", None]),
    "date": ("date32", [date(1969, 12, 31), date(2024, 3, 1), date(2024, 3, 2), date(2261, 1, 1)], [None]),
    "ISO text": ("string", ["1969-12-31", "2024-03-01T10:00", "2024-03-01 10:00:00.5Z", "2024-03-02"], [None, ""]),
    "timestamp of seconds": ("timestamp[s]", _times(timedelta(seconds=1)), [None]),
    "timestamp of microseconds": ("timestamp[us]", _times(timedelta(microseconds=1)), [None]),
    "timestamp of nanoseconds": ("timestamp[ns]", _times(timedelta(microseconds=1)), []),
    "timestamp of UTC": ("timestamp[us, UTC]", _times(timedelta(milliseconds=1), UTC), [None]),
}
"""Arrow type of a column, two cells of the class "low" and two of "high", and cells that are missing, of "low"."""


def _array(kind: str, cells: list[Any]) -> Any:
    arrow = pytest.importorskip("pyarrow")
    if kind == "dictionary":
        return arrow.array(cells, arrow.string()).dictionary_encode()
    if kind.startswith("decimal"):
        return arrow.array(cells, arrow.decimal128(9, 2))
    if kind == "timestamp[us, UTC]":
        return arrow.array(cells, arrow.timestamp("us", "UTC"))
    return arrow.array(cells, arrow.type_for_alias(kind))


def _table(case: str) -> Callable[[Path], tuple[Path, list[str]]]:
    """Return what writes a column as Parquet, beside the label of each row, which is what a tree must answer."""

    def make(folder: Path) -> tuple[Path, list[str]]:
        kind, known, missing = CELLS[case]
        labels = ["low", "low", "high", "high"] + ["low"] * len(missing)
        parquet = pytest.importorskip("pyarrow.parquet")
        column = _array(kind, [*known, *missing] * 3)
        arrow = importlib.import_module("pyarrow")
        table = arrow.table({"a b": column, ROW: range(len(column)), "class": labels * 3})
        parquet.write_table(table, folder / "table.parquet")
        return folder / "table.parquet", labels * 3

    return make


def _sql(tree: Path, *words: str) -> str:
    out = tree.with_suffix(".sql")
    command("report", tree, "--out", out, *words)
    return out.read_text()


def _in_databases(made: tuple[Path, list[str]]) -> dict[str, bool]:
    """Return for each database that is here whether the expression of a solved tree answers the labels."""
    path, labels = made
    tree = path.with_name("tree.json")
    command("solve", path, "--label", "class", "--drop", ROW, "--depth", "1", "--categories", "subsets", "--out", tree)
    found = {}
    for name, (run, version) in ENGINES.items():
        if version():
            answers = [row[0] for row in run(path, [_sql(tree)])]
            found[name] = all(map(same, answers, labels)) or answers
    return found


def _everywhere(_: object) -> dict[str, bool]:
    return {name: True for name, (_, version) in ENGINES.items() if version()}


def _csv(content: str, *words: str) -> Callable[[Path], Path]:
    """Return what solves a table of text and returns the tree."""

    def make(folder: Path) -> Path:
        (folder / "table.csv").write_text(content)
        command("solve", folder / "table.csv", *words, "--out", folder / "tree.json")
        return folder / "tree.json"

    return make


def _lines(*rows: str, times: int = 3) -> str:
    header, *cells = rows
    return "\n".join([header, *cells * times]) + "\n"


def _sqlite_of_csv(tree: Path) -> list[Any]:
    """Return what SQLite answers over the table as its shell imports CSV: all cells texts, empty ones too."""
    script = f'.import --csv "{tree.with_name("table.csv")}" t\nSELECT {_sql(tree, "--table", "t")} FROM t;\n'
    done = subprocess.run(["sqlite3", ":memory:"], input=script, capture_output=True, text=True, check=True)
    return done.stdout.split()


def _needs_sqlite_shell(make: Callable[[Path], Path]) -> Callable[[Path], Path]:
    def checked(folder: Path) -> Path:
        if subprocess.run(["which", "sqlite3"], capture_output=True).returncode:
            pytest.skip("no shell of SQLite")
        return make(folder)

    return checked


def _c_answers(tree: Path, rows: list[tuple[float, ...]]) -> list[Any]:
    out = tree.with_name("tree.c")
    command("report", tree, "--out", out)
    predicted = _compiled(out, "-std=c99").octmip_predict
    predicted.restype = ctypes.c_char_p if "const char *octmip_predict" in out.read_text() else ctypes.c_double
    found = [predicted((ctypes.c_double * len(row))(*row)) for row in rows]
    return [one.decode() if isinstance(one, bytes) else None if one is None or one != one else one for one in found]


def _compiled(source: Path, *flags: str, compiler: str = "gcc") -> Any:
    strict = ("-Wall", "-Wextra", "-Wpedantic", "-Wconversion", "-Werror", "-shared", "-fPIC")
    library = source.with_suffix(".so")
    done = subprocess.run([compiler, *flags, *strict, "-o", library, source], capture_output=True, text=True)
    if done.returncode:
        raise DataError(done.stderr.splitlines()[0])
    return ctypes.CDLL(str(library))


def _needs_gcc(make: Callable[[Path], Any]) -> Callable[[Path], Any]:
    def checked(folder: Path) -> Any:
        if subprocess.run(["which", "gcc"], capture_output=True).returncode:
            pytest.skip("no gcc")
        return make(folder)

    return checked


def _fast(flag: str) -> Callable[[Path], Any]:
    def ask(tree: Path) -> Any:
        command("report", tree, "--out", tree.with_name("tree.c"))
        return _compiled(tree.with_name("tree.c"), flag)

    return ask


def _as_cpp(tree: Path) -> int:
    source = tree.with_name("tree.c")
    command("report", tree, "--out", source)
    source.with_suffix(".cpp").write_text(source.read_text())
    return subprocess.run(
        ["g++", "-std=c++11", "-Wall", "-Wextra", "-Wpedantic", "-Wconversion", "-Werror", "-c", "tree.cpp"],
        cwd=tree.parent,
        capture_output=True,
    ).returncode


def _onnx_answers(feed: dict[str, Any]) -> Callable[[Path], list[Any]]:
    def ask(tree: Path) -> list[Any]:
        runtime = pytest.importorskip("onnxruntime")
        command("report", tree, "--out", tree.with_name("tree.onnx"))
        session = runtime.InferenceSession(tree.with_name("tree.onnx"), providers=["CPUExecutionProvider"])
        return [None if one != one else one for one in session.run(None, feed)[0].tolist()]

    return ask


def _is_refused(suffix: str) -> Callable[[Path], str]:
    return lambda tree: command("report", tree, "--out", tree.with_name(f"other{suffix}"))


ROD = """
def rod(parameters, loads):
    return {"u": loads["force"] * (1 + parameters["crack"]), "v": loads["force"] * 0.5}
"""
CARD = {"readings": {"u": "mm", "v": "mm"}, "loads": ["force"], "states": ["crack"], "state_limits": {"crack": 0.8}}


def _rod(folder: Path) -> Path:
    (folder / "their_rod.py").write_text(ROD)
    (folder / "rod.json").write_text(json.dumps(CARD | {"linear": True}))
    (folder / "raw.csv").write_text("u,v\n20,10\n36,10\n")  # sound, and with a crack beyond the greatest level
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(folder)
        words = ("--load", "force=20", "--noise", "mm=0.05", "--out", folder / "out")
        command("monitor", "--twin", "python:their_rod:rod", "--card", folder / "rod.json", *words)
    return folder


def _of_raw_readings(folder: Path) -> tuple[list[float], list[bool]]:
    told = [float(line) for line in command("predict", folder / "out/crack.json", folder / "raw.csv").split()[1:]]
    said = [(folder / "out" / name).read_text() for name in ("crack.c", "crack.json", "crack.html")]
    words = ("force", "20", "mm", "0.64")
    return [round(level, 9) for level in told], [all(word in one for word in words) for one in said]


NUMBERS = _csv(_lines("a,y", "1,10.5", "2,10.5", "3,-20", "4,-20"), "--target", "y", "--depth", "1")
TEXTS = _csv(_lines("a,m,y", "1,press,good", "2,pump,bad", "2,saw,good"), "--label", "y", "--depth", "1")
MISSING = _csv(_lines("a,y", "1,7", "2,7", ",7", "3,0", "4,0"), "--label", "y", "--depth", "1")
NO_SIDE = _csv(_lines("a,y", "1,7", "2,7", "3,0", "4,0"), "--label", "y", "--depth", "1")
TEXT_ANSWERS = ["good", "bad", "good", None, "good"]
TEXT_ROWS = [(1.0, code) for code in (0.0, 1.0, 2.0, NAN, -1.0)]
SQL, C, ONNX = (f"octmip report --out {name}" for name in ("x.sql", "x.c", "x.onnx"))
BY_MISSING = ["7", "7", "7", "0", "0"] * 3


def _refused(case: str, rows: tuple[str, ...], suffix: str, *words: str, options: tuple[str, ...] = ()) -> Row:
    label = options or ("--label", "y", "--depth", "1")
    door = {".sql": SQL, ".c": C, ".onnx": ONNX}[suffix]
    return Row(door, "a table of text", case, _csv(_lines(*rows), *label), _is_refused(suffix), Refused(words))


DAYS = ("d,y", "14/03/2025,a", "15/03/2025,a", "16/03/2025,b", "17/03/2025,b")
ZONE = ("d,y", "2025-03-14 10:00+02:00,a", "2025-03-14 11:00+02:00,a", "2025-03-14 12:00+02:00,b")
MONEY = ("d,y", "$5.00,a", "$6.00,a", "$7.00,b", "$8.00,b")
SLASH = ("d,y", "a\\,a", "b,b", "c,b")
CASES = ("d,D,y", "1,1,a", "1,2,b", "2,1,b", "2,2,a")
ROWS = [
    *(Row(SQL, "pyarrow, read by each database", case, _table(case), _in_databases, _everywhere) for case in CELLS),
    Row(SQL, "SQLite's .import", "empty cells are texts", _needs_sqlite_shell(MISSING), _sqlite_of_csv, BY_MISSING),
    _refused("dates day first", DAYS, ".sql", "column d holds dates", "ISO text", "export to C or ONNX"),
    _refused("times of another zone", ZONE, ".sql", "zone +02:00", "UTC"),
    _refused("amounts with a sign", MONEY, ".sql", "column d holds amounts in $", "plain numbers"),
    _refused("a text with a backslash", SLASH, ".sql", "backslash", "ClickHouse", "rename"),
    _refused("columns that differ in case", CASES, ".sql", "in case only", options=("--label", "y", "--depth", "2")),
    *(Row(C, "gcc", case, _needs_gcc(make), partial(_c_answers, rows=rows), right)
      for case, make, rows, right in (
          ("a tree of numbers", NUMBERS, [(2.0,), (3.0,), (NAN,)], [10.5, -20.0, None]),
          ("texts by the codes of the head, missing and another", TEXTS, TEXT_ROWS, TEXT_ANSWERS),
          ("a missing reading goes to its side", MISSING, [(NAN,), (4.0,)], [7.0, 0.0]),
          ("a missing reading has no class", NO_SIDE, [(NAN,), (4.0,)], [None, 0.0]))),
    *(Row(C, f"gcc {flag}", "takes NaN for a number", _needs_gcc(MISSING), _fast(flag), Refused(("error",)))
      for flag in ("-ffast-math", "-Ofast", "-ffinite-math-only")),
    Row(C, "g++", "no warning as C++", _needs_gcc(TEXTS), _as_cpp, 0),
    Row(ONNX, "onnxruntime", "a tree of numbers", NUMBERS,
        _onnx_answers({"readings": np.array([[2.0], [3.0], [NAN]])}), [10.5, -20.0, None]),
    Row(ONNX, "onnxruntime", "a column of texts is an input of texts", TEXTS,
        _onnx_answers({"m": np.array([["press"], ["pump"], ["saw"], [""], ["lathe"]], dtype=object)}),
        ["good", "bad", "good", "", "good"]),
    Row("octmip monitor --load", "a function of Python", "raw readings at a load of 20", _rod, _of_raw_readings,
        ([0.0, 0.64], [True, True, True])),
]  # fmt: skip
