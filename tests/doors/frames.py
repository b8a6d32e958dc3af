"""Frames of other libraries as samples of the estimators: a column of each type beside a column of numbers.

The right answer counts partitions of the rows by the values as Python has them: an ordered column has its cuts, a text
the questions for its values, and a cut has missing cells on either side. No door is asked for it.
"""

import datetime as dt
import itertools
from collections.abc import Callable, Iterator, Sequence
from decimal import Decimal
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
from sklearn.model_selection import cross_val_score

from octmip import OptimalTreeClassifier, OptimalTreeRegressor
from tests.doors.row import Refused, Row

LABELS = np.array([1, 0, 1, 0, 0, 1, 1, 1, 0, 1, 1, 0])
HOURS = [5.0, 1.0, 4.0, 2.0, 6.0, 3.0, 1.0, 5.0, 2.0, 6.0, 4.0, 3.0]
PLACES = [3, 1, 7, 2, None, 8, 6, 9, 0, 7, 5, 4]
"""The place of each row's cell in the order of a column's values, None where it is missing."""
DAY = dt.date(2024, 1, 30)
DAYS = [DAY + dt.timedelta(days=19 * k) for k in range(10)]
MOMENTS = [dt.datetime(2024, 2, 28, 23, 59, 59) + k * dt.timedelta(seconds=1, microseconds=7) for k in range(10)]
Values = Sequence[Any]


def at_places(values: Values, *, missing: bool = True) -> list[Any]:
    """Return the cell of each row, None where it is missing, or the first value where the type has no missing ones."""
    return [values[0 if k is None and not missing else k] if k is not None or not missing else None for k in PLACES]


def partitions(places: Sequence[int | None], *, is_text: bool) -> Iterator[np.ndarray[Any, Any]]:
    """Yield each way in which one question parts the rows."""
    lacks = np.array([place is None for place in places])
    number = np.array([-1 if place is None else place for place in places])
    yield lacks
    for k in range(10):
        yes = number == k if is_text else number <= k
        yield yes & ~lacks
        if not is_text:  # a missing text is a value of its own
            yield yes | lacks


def least(targets: np.ndarray[Any, Any], places: Sequence[int | None], is_text: bool, predicts: str) -> float:
    """Return the least training cost of one question about either column: wrong samples, or squared error."""

    def cost(side: np.ndarray[Any, Any]) -> float:
        part = targets[side]
        if not len(part):
            return 0.0
        return float(
            np.bincount(part).sum() - np.bincount(part).max() if predicts == "class" else part.var() * len(part)
        )

    asked = itertools.chain(
        partitions(places, is_text=is_text), partitions([int(hour) for hour in HOURS], is_text=False)
    )
    return min(cost(side) + cost(~side) for side in asked)


def fitted(predicts: str) -> Callable[[Any], Any]:
    """Return what asks an estimator of one split: its training cost by the proof, and by its own predictions."""

    def ask(frame: Any) -> tuple[float, float]:
        kind = OptimalTreeClassifier if predicts == "class" else OptimalTreeRegressor
        model = kind(max_depth=1).fit(frame, LABELS)
        missed = np.asarray(model.predict(frame)) - LABELS
        return round(model.objective_, 9), round(float((missed**2).sum()), 9)

    return ask


def of_pandas(column: Callable[[], Any]) -> Callable[[Path], Any]:
    return lambda folder: pd.DataFrame({"hours": HOURS, "x": column()})


def of_polars(values: list[Any], kind: str) -> Callable[[Path], Any]:
    def make(folder: Path) -> Any:
        pl = pytest.importorskip("polars")
        types = {
            "": None,
            "Int64": pl.Int64,
            "Categorical": pl.Categorical,
            "Enum": pl.Enum(sorted({value for value in values if value is not None}, key=str))
            if kind == "Enum"
            else None,
            "Decimal": pl.Decimal(12, 2),
            "Datetime ns": pl.Datetime("ns"),
            "UInt8": pl.UInt8,
            "Float32": pl.Float32,
        }
        return pl.DataFrame({"hours": HOURS, "x": pl.Series(values, dtype=types[kind])})

    return make


def of_arrow(values: list[Any], kind: str = "") -> Callable[[Path], Any]:
    def make(folder: Path) -> Any:
        pa = pytest.importorskip("pyarrow")
        types = {"": None, "view": pa.string_view(), "zone": pa.timestamp("us", "Asia/Tokyo"), "half": pa.float16()}
        return pa.table({"hours": HOURS, "x": pa.array(values, types[kind]) if kind else pa.array(values)})

    return make


def of_duckdb(values: list[Any]) -> Callable[[Path], Any]:
    def make(folder: Path) -> Any:
        duckdb = pytest.importorskip("duckdb")
        pa = pytest.importorskip("pyarrow")
        return duckdb.from_arrow(pa.table({"hours": HOURS, "x": pa.array(values)}))

    return make


NUMBERS, WORDS = [float(k) for k in range(10)], [f"w{k}" for k in range(10)]
SPANS, AMOUNTS = [k * dt.timedelta(hours=7) for k in range(10)], [Decimal(k) / 4 for k in range(10)]
PANDAS: dict[str, tuple[Callable[[], Any], str]] = {
    "datetime64": (lambda: pd.to_datetime(pd.Series(at_places(DAYS))), "order"),
    "datetime64[s] beyond the year 2262": (
        lambda: pd.Series(at_places([day.replace(year=9990) for day in DAYS])).astype("datetime64[s]"),
        "order",
    ),
    "datetime64 with a time zone": (
        lambda: pd.to_datetime(pd.Series(at_places(MOMENTS))).dt.tz_localize("UTC"),
        "order",
    ),
    "timedelta64": (lambda: pd.to_timedelta(pd.Series(at_places(SPANS))), "order"),
    "period": (lambda: pd.Series(pd.to_datetime(pd.Series(at_places(DAYS)))).dt.to_period("D"), "order"),
    "objects: dates": (lambda: pd.Series(at_places(DAYS), dtype=object), "order"),
    "objects: numpy's dates": (
        lambda: pd.Series(at_places([np.datetime64(day) for day in DAYS]), dtype=object),
        "order",
    ),
    "objects: durations": (lambda: pd.Series(at_places(SPANS), dtype=object), "order"),
    "objects: Decimal": (lambda: pd.Series(at_places(AMOUNTS), dtype=object), "order"),
    "objects: numbers and pd.NA": (lambda: pd.Series(at_places([*range(10)]), dtype=object).fillna(pd.NA), "order"),
    "Int64": (lambda: pd.array(at_places([*range(10)]), dtype="Int64"), "order"),
    "Float32": (lambda: pd.array(at_places(NUMBERS), dtype="Float32"), "order"),
    "float32": (lambda: np.array(at_places(NUMBERS), dtype=np.float32), "order"),
    "int64[pyarrow]": (lambda: pd.array(at_places([*range(10)]), dtype="int64[pyarrow]"), "order"),
    "date32[pyarrow]": (lambda: pd.array(at_places(DAYS), dtype="date32[pyarrow]"), "order"),
    "sparse": (lambda: pd.arrays.SparseArray(at_places(NUMBERS, missing=False)), "order, none missing"),
    "string": (lambda: pd.array(at_places(WORDS), dtype="string"), "text"),
    "string[pyarrow]": (lambda: pd.array(at_places(WORDS), dtype="string[pyarrow]"), "text"),
    "category": (lambda: pd.Categorical(at_places(WORDS)), "text"),
    "category of dates": (lambda: pd.Categorical(at_places(DAYS)), "order"),
    "ordered category": (lambda: pd.Categorical(at_places(WORDS), WORDS, ordered=True), "order"),
}
ARROWS: dict[str, tuple[Values, str]] = {
    "date": (DAYS, "order"),
    "datetime": (MOMENTS, "order"),
    "duration": (SPANS, "order"),
    "decimal": (AMOUNTS, "order"),
    "integer": ([*range(10)], "order"),
    "text": (WORDS, "text"),
}
POLARS: dict[str, tuple[Values, str, str]] = {
    **{case: (values, meaning, "") for case, (values, meaning) in ARROWS.items()},
    "time": ([dt.time(8, k, 30) for k in range(10)], "order", ""),
    "Categorical": (WORDS, "text", "Categorical"),
    "Enum": (WORDS, "text", "Enum"),
    "Decimal": (AMOUNTS, "order", "Decimal"),
    "Datetime ns": (MOMENTS, "order", "Datetime ns"),
    "UInt8": ([*range(10)], "order", "UInt8"),
    "Float32": (NUMBERS, "order", "Float32"),
}


def row(writer: str, case: str, make: Callable[[Path], Any], meaning: str, predicts: str) -> Row:
    """Return the row of a column; its `meaning` is that of its values: an order or texts."""
    places = [0 if place is None and "none missing" in meaning else place for place in PLACES]
    cost = round(least(LABELS, places, meaning == "text", predicts), 9)
    return Row(f"estimator of {predicts}", writer, case, make, fitted(predicts), (cost, cost))


def refused(writer: str, case: str, make: Callable[[Path], Any], *words: str) -> Row:
    return Row("estimator of class", writer, case, make, fitted("class"), Refused(words))


def _twice(folder: Path) -> Any:
    return pd.DataFrame(np.arange(24.0).reshape(12, 2), columns=["x", "x"])


def _strings(folder: Path) -> Any:
    return pytest.importorskip("polars").Series(["b" if label else "a" for label in LABELS])


def learned(labels: Any) -> tuple[list[Any], list[float]]:
    """Return the classes that were found in labels, and the scores of folds."""
    hours = np.array(HOURS)[:, None]
    scores = cross_val_score(OptimalTreeClassifier(max_depth=1), hours, labels, cv=2)
    return OptimalTreeClassifier(max_depth=1).fit(hours, labels).classes_.tolist(), np.isfinite(scores).tolist()


LABELLED: dict[tuple[str, str], tuple[Callable[[Path], Any], list[Any]]] = {
    ("numpy", "whole numbers among objects"): (lambda folder: LABELS.astype(object), [0, 1]),
    ("numpy", "Booleans among objects"): (lambda folder: LABELS.astype(bool).astype(object), [False, True]),
    ("pandas", "whole numbers among objects"): (lambda folder: pd.Series(LABELS, dtype=object), [0, 1]),
    ("polars", "texts, which Arrow has as views"): (_strings, ["a", "b"]),
}
ROWS: list[Row] = [
    *(
        Row("estimator's labels", *key, make, learned, (classes, [True, True]))
        for key, (make, classes) in LABELLED.items()
    ),
    *(
        row("pandas", case, of_pandas(make), meaning, p)
        for case, (make, meaning) in PANDAS.items()
        for p in ("class", "number")
    ),
    *(
        row("polars", case, of_polars(at_places(v), kind), m, p)
        for case, (v, m, kind) in POLARS.items()
        for p in ("class", "number")
    ),
    *(
        row("pyarrow", case, of_arrow(at_places(v)), m, p)
        for case, (v, m) in ARROWS.items()
        for p in ("class", "number")
    ),
    row("pyarrow", "string_view", of_arrow(at_places(WORDS), "view"), "text", "class"),
    row("pyarrow", "timestamp with a zone", of_arrow(at_places(MOMENTS), "zone"), "order", "class"),
    *(row("DuckDB", case, of_duckdb(at_places(v)), m, "class") for case, (v, m) in ARROWS.items()),
    refused("pandas", "two columns of one name", _twice, "two columns called 'x'", "rename"),
    refused("pandas", "integers beyond 2^53", of_pandas(lambda: [2**60 + k for k in range(12)]), "'x'", "beyond 2^53"),
    refused(
        "polars", "integers beyond 2^53 with nulls", of_polars([2**60 + 1, None] * 6, "Int64"), "'x'", "beyond 2^53"
    ),
    refused(
        "pandas",
        "Decimal beyond 2^53",
        of_pandas(lambda: [Decimal(2**60 + k) for k in range(12)]),
        "'x'",
        "beyond 2^53",
    ),
    refused("pandas", "dates beside words", of_pandas(lambda: [DAY, "soon"] * 6), "'x'", "of type date"),
    refused(
        "pandas",
        "nanoseconds",
        of_pandas(lambda: pd.to_datetime(pd.Series(range(10**18, 10**18 + 12)))),
        "'x'",
        "closer",
    ),
    refused("pandas", "complex numbers", of_pandas(lambda: [1j, None] * 6), "'x'", "complex"),
    refused("pandas", "intervals", of_pandas(lambda: pd.Series(pd.interval_range(0, 12))), "'x'", "of type Interval"),
    refused("pyarrow", "lists", of_arrow([[1], [2]] * 6), "'x'", "expected numbers or text"),
    refused("pyarrow", "bytes", of_arrow([b"a", b"b"] * 6), "'x'", "of type bytes"),
]
