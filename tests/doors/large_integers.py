"""Doors that make float64 of whole numbers: one beyond 2^53 that float64 does not hold is refused by name."""

import csv
import importlib
import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest

from octmip import OptimalTreeClassifier, OptimalTreeRegressor, Problem, solve
from octmip.trees.question.losses import SquaredError
from tests.doors.row import Refused, Row, command

FIRST = 2**53 + 1
LARGE = [FIRST, FIRST + 1, FIRST + 2, FIRST + 3]
"""float64 takes the second and the third for one."""
HOLED: list[int | None] = [*LARGE[:3], None]
EXACT = [2**60 + 512 * k for k in range(4)]
"""float64 holds each of them."""
CLASSES = ["a", "b", "a", "b"]
READINGS = [[0], [1], [2], [3]]
REFUSED = Refused(("beyond 2^53", "subtract an offset"))


def table_of(writer: str, values: list[int | None]) -> Any:
    """Return a table of one column t, made by a program."""
    if writer == "numpy masked":
        return np.ma.masked_equal([[value or 0] for value in values], 0)
    if writer.startswith("numpy"):
        kind = {"numpy int64": np.int64, "numpy uint64": np.uint64, "numpy object": object}[writer]
        return np.array(values, dtype=kind)[:, None]
    if writer == "lists":
        return [[value, 0.5] for value in values]
    if writer.startswith("pandas"):
        pytest.importorskip("pyarrow")
        kind = {"pandas int64": "int64", "pandas Int64": "Int64", "pandas arrow": "int64[pyarrow]"}[writer]
        return pd.DataFrame({"t": pd.Series(values, dtype=kind)})
    module = pytest.importorskip(writer)
    return module.DataFrame({"t": values}) if writer == "polars" else module.table({"t": values})


def objective(features: Any) -> float:
    return solve(Problem(features, CLASSES, depth=2)).objective


def fitted(features: Any) -> float:
    return OptimalTreeClassifier(2).fit(features, CLASSES).objective_


def file_of(writer: str, folder: Path, values: Sequence[int | None] = LARGE) -> Path:
    path = folder / f"ids.{writer.split()[1]}"
    frame = pd.DataFrame({"t": pd.Series(values, dtype="Int64"), "x": range(len(values)), "y": CLASSES[: len(values)]})
    if writer.startswith("pandas parquet"):
        importlib.import_module("pyarrow")
        (frame.astype({"t": "category"}) if writer.endswith("categories") else frame).to_parquet(path)
    elif writer.startswith("Excel"):  # groups of three
        path.write_text(
            "t;y\n" + "".join(f"{v:,};{c}\n".replace(",", " ") for v, c in zip(LARGE, CLASSES, strict=True))
        )
    else:
        quoting = csv.QUOTE_ALL if writer.endswith("quoted") else csv.QUOTE_MINIMAL
        frame.to_csv(path, index=False, sep="\t" if "tsv" in writer else ",", quoting=quoting)
    return path


def solved(path: Path, *words: str) -> str:
    return command("solve", path, *words, "--depth", "2", "--drop-unlabelled")


def classes_of(path: Path) -> list[Any]:
    tree = path.with_name("tree.json")
    solved(path, "--label", "t", "--drop", "y", "--out", str(tree))
    return list(json.loads(tree.read_text())["class_names"])


def row(door: str, writer: str, case: str, make: Any, ask: Any, answer: Any = REFUSED) -> Row:
    return Row(door, writer, f"whole numbers: {case}", make, ask, answer)


def of_table(door: str, writer: str, case: str = "a feature", values: Any = LARGE, answer: Any = REFUSED) -> Row:
    """Return the row of a table of features."""
    ask = objective if door == "Problem" else fitted
    return row(door, writer, case, lambda _: table_of(writer, values), ask, answer)


def of_file(writer: str, case: str, values: Sequence[int | None], ask: Any, answer: Any = REFUSED) -> Row:
    return row("octmip solve TABLE", writer, case, lambda folder: file_of(writer, folder, values), ask, answer)


def of_labels(door: str, case: str, ask: Any, answer: Any) -> Row:
    return row(door, "numpy int64", case, lambda _: np.array(LARGE), ask, answer)


def as_feature(path: Path) -> str:
    return solved(path, "--label", "y")


def as_target(path: Path) -> str:
    return solved(path, "--target", "t", "--drop", "y")


WRITERS = ("numpy int64", "numpy uint64", "numpy object", "lists", "pandas int64", "pandas Int64", "pandas arrow")
FILES = ("pandas csv", "pandas csv, quoted", "pandas tsv", "pandas parquet")
ROWS: list[Row] = [
    *(of_table("Problem", writer) for writer in (*WRITERS, "polars", "pyarrow")),
    *(of_table("OptimalTreeClassifier", writer) for writer in WRITERS),
    *(
        of_table("Problem", writer, "a feature, one missing", HOLED)
        for writer in ("numpy masked", "pandas Int64", "pandas arrow", "polars", "pyarrow")
    ),
    *(of_table("Problem", writer, "a feature, exact", EXACT, 0.0) for writer in (*WRITERS, "polars", "pyarrow")),
    *(of_file(writer, "a feature", LARGE, as_feature) for writer in ("pandas csv", "pandas parquet", "Excel csv")),
    *(of_file(writer, "a feature, one missing", HOLED, as_feature) for writer in FILES),
    of_file("pandas parquet of categories", "a feature, one missing", HOLED, as_feature),
    *(of_file(writer, "targets, one missing", HOLED, as_target) for writer in FILES),
    *(of_file(writer, "classes, one missing", HOLED, classes_of, LARGE[:3]) for writer in FILES),
    of_labels("Problem", "targets", lambda y: Problem(READINGS, y, depth=2, loss=SquaredError()), REFUSED),
    of_labels("OptimalTreeRegressor", "targets", lambda y: OptimalTreeRegressor(2).fit(READINGS, y), REFUSED),
    of_labels("Problem", "classes", lambda y: list(Problem(READINGS, y, depth=2).samples.class_names), LARGE),
    of_labels(
        "OptimalTreeClassifier",
        "classes",
        lambda y: OptimalTreeClassifier(2).fit(READINGS, y).predict(READINGS).tolist(),
        LARGE,
    ),
]
