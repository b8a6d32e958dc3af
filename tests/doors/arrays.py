"""Arrays and columns of other libraries as the samples of a Problem: masks, fields, queries, what is no number.

Row k of the truth is the number of the row; every third is missing. The right answer is those numbers by name.
"""

from collections.abc import Callable
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest

from octmip import Leaf, OptimalTreeClassifier, Problem, Split, predict
from tests.doors.row import Refused, Row

N = 9
NUMBERS = np.arange(float(N))
LOST = np.arange(N) % 3 == 0
LABELS = ["a", "b", "b"] * 3
KEPT = tuple(None if gone else k for k, gone in zip(NUMBERS.tolist(), LOST, strict=True))
MASKED = np.ma.masked_array(np.where(LOST, -1.0, NUMBERS), LOST)
WHOLE = np.ma.masked_array(np.where(LOST, -1, NUMBERS).astype(np.int64), LOST)
FIELDS = np.rec.fromarrays([NUMBERS[::-1], np.where(LOST, np.nan, NUMBERS)], names=["u", "v"])
MASKED_FIELDS = np.ma.masked_array(FIELDS, [(False, gone) for gone in LOST])


def seen(features: Any) -> tuple[Any, ...]:
    """Return the numbers of the last column of a Problem, None where one is missing."""
    column = Problem(features, LABELS, depth=1).samples.features[:, -1]
    return tuple(None if np.isnan(number) else number for number in column.tolist())


def taken(features: Any) -> tuple[Any, ...]:
    """Return the same of an estimator, by the answers of a tree that parts each row."""
    model = OptimalTreeClassifier(max_depth=1).fit(features, LABELS)
    assert (model.predict(features) == LABELS).all()
    return KEPT


def asked(features: Any) -> list[int]:
    """Return the answers of a tree that asks whether the last column is above 4, and right where it is missing."""
    names = getattr(getattr(features, "dtype", None), "names", None) or (
        features if isinstance(features, dict) else "v"
    )
    last = len(names) - 1
    return predict(Split(last, 4.0, Leaf(0), Leaf(2), missing="right"), features).tolist()


def labelled(labels: Any) -> tuple[Any, ...]:
    return Problem(NUMBERS[:, None], labels, depth=1).samples.class_names


def weighed(weights: Any) -> list[float]:
    return Problem(NUMBERS[:, None], LABELS, depth=1, weights=weights).samples.weights.tolist()


def _polars(change: Callable[[Any], Any]) -> Callable[[Path], Any]:
    def make(folder: Path) -> Any:
        polars = pytest.importorskip("polars")
        return change(polars.DataFrame({"v": [None if k is None else int(k) for k in KEPT]}))

    return make


FEATURES: dict[tuple[str, str], tuple[Callable[[Path], Any], Any]] = {
    ("numpy", "a mask over -1"): (lambda folder: MASKED[:, None], KEPT),
    ("numpy", "a mask over whole numbers"): (lambda folder: WHOLE[:, None], KEPT),
    ("numpy", "fields"): (lambda folder: FIELDS, KEPT),
    ("numpy", "fields under a mask"): (lambda folder: MASKED_FIELDS, KEPT),
    ("Python", "a mapping"): (lambda folder: {"u": NUMBERS, "v": MASKED}, KEPT),
    ("pandas", "sparse"): (
        lambda folder: pd.DataFrame({"v": pd.arrays.SparseArray(np.where(LOST, np.nan, NUMBERS))}),
        KEPT,
    ),
    ("polars", "whole numbers with nulls"): (_polars(lambda frame: frame), KEPT),
    ("polars", "a query"): (_polars(lambda frame: frame.lazy()), Refused(("LazyFrame", "collect()"))),
    ("numpy", "nanoseconds"): (
        lambda folder: (10**18 + np.arange(N)).astype("datetime64[ns]")[:, None],
        Refused(("datetime64[ns]", "expected numbers")),
    ),
    ("numpy", "complex"): (lambda folder: NUMBERS[:, None] + 1j, Refused(("complex128", "expected numbers"))),
    ("pandas", "dates"): (
        lambda folder: pd.DataFrame({"v": pd.to_datetime(["2026-03-01"] * N)}),
        Refused(("'v'", "expected numbers")),
    ),
    ("pandas", "lists"): (lambda folder: pd.DataFrame({"v": [[1.0, 2.0]] * N}), Refused(("'v'", "expected numbers"))),
    ("Python", "fractions"): (lambda folder: {"v": [Fraction(k, 1) for k in range(N)]}, tuple(NUMBERS.tolist())),
}
ROWS = [
    *(Row("Problem's features", *key, make, seen, right) for key, (make, right) in FEATURES.items()),
    *(
        Row("predict", *key, make, asked, [2 if k is None or k > 4 else 0 for k in KEPT] if right is KEPT else right)
        for key, (make, right) in FEATURES.items()
        if key[1] != "fractions" and (right is KEPT or key[1] in ("complex", "a query", "nanoseconds"))
    ),
    Row("estimator's fields", "numpy", "fields under a mask", lambda folder: MASKED_FIELDS, taken, KEPT),
    Row(
        "Problem's labels",
        "numpy",
        "a mask",
        lambda folder: np.ma.masked_array([1, 2] * 4 + [1], LOST),
        labelled,
        Refused(("labels[0]", "3 of 9 labels are missing")),
    ),
    Row("Problem's weights", "numpy", "a mask", lambda folder: MASKED, weighed, Refused(("weights[0]", "not finite"))),
    Row(
        "estimator's frame",
        "polars",
        "128-bit integers",
        _polars(lambda frame: frame.cast(pytest.importorskip("polars").Int128)),
        taken,
        Refused(("Arrow cannot take", "cast")),
    ),
]
