"""Doors that take `monotone`: the order of the classes is the one that the other program says, or is asked for."""

import json
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import pandas as pd
import pytest

from octmip import OptimalTreeClassifier, Problem, solve
from tests.doors.row import Refused, Row, command

LEVELS = {
    "severity": ("low", "mid", "high"),
    "check": ("ok", "warn", "fail"),
    "state": ("healthy", "damaged"),
    "wear": ("sound", "worn", "failed"),
    "grade": ("none", "minor", "major"),
}
"""Orders that the alphabet does not know."""
OWN = {"compare": ("--methods", "exact"), "frontier": ("--over", "penalty")}
ROWS_OF_EACH = 3
NO_ORDER = Refused(("texts", "no order", "--class-order"))


def samples(levels: tuple[str, ...]) -> tuple[list[int], list[str]]:
    """Return a crack that rises with the level: an ordered tree errs in no row, one in another order in some."""
    rows = [k for k in range(len(levels)) for _ in range(ROWS_OF_EACH)]
    return rows, [levels[k] for k in rows]


def pandas_frame(levels: tuple[str, ...], *, is_ordered: bool = True) -> pd.DataFrame:
    crack, words = samples(levels)
    state = pd.Categorical(words, levels, ordered=True) if is_ordered else words
    return pd.DataFrame({"crack": crack, "state": state})


def written(writer: str, levels: tuple[str, ...]) -> Callable[[Path], Path]:
    """Return what writes a table with a program."""

    def make(folder: Path) -> Path:
        crack, words = samples(levels)
        path = folder / f"table.{'csv' if writer == 'pandas csv' else 'parquet'}"
        if writer == "pandas csv":
            pandas_frame(levels).to_csv(path, index=False)
        elif writer == "pandas":
            pytest.importorskip("pyarrow")
            pandas_frame(levels).to_parquet(path)
        elif writer.startswith("polars"):
            polars = pytest.importorskip("polars")
            kind = polars.Enum(levels) if writer == "polars Enum" else polars.Categorical
            polars.DataFrame({"crack": crack, "state": polars.Series(words, dtype=kind)}).write_parquet(path)
        else:
            arrow = pytest.importorskip("pyarrow")
            codes = [levels.index(word) for word in words]
            state = arrow.DictionaryArray.from_arrays(codes, list(levels), ordered=True)
            table = arrow.table({"crack": crack, "state": state})
            pytest.importorskip("pyarrow.parquet").write_table(table, path)
        return path

    return make


def solved(path: Path, *words: str) -> tuple[int, bool, tuple[Any, ...]]:
    """Return errors, whether they are proven, and the order, by `octmip solve`."""
    asked = ("--label", "state", "--depth", "2", "--monotone", "crack=+", "--json", *words)
    found = json.loads(command("solve", path, *asked))
    return found["errors"], found["is_optimal"], tuple(found["class_order"])


def other_command(name: str) -> Callable[[Path], bool]:
    """Return whether a command with an order says a tree without an error."""

    def ask(path: Path) -> bool:
        asked = ("--label", "state", "--depth", "2", "--monotone", "crack=+", "--json", *OWN[name])
        return '"errors": 0' in command(name, path, *asked, "--class-order", ",".join(LEVELS["check"]))

    return ask


def fitted(levels: tuple[str, ...], y: Any, **options: Any) -> tuple[float, bool, tuple[Any, ...], bool]:
    """Return objective, proof and order of an estimator, and whether predictions and probabilities are its classes'."""
    crack, words = samples(levels)
    tree = OptimalTreeClassifier(2, monotonic_cst=[1], smoothing=0, **options).fit([[x] for x in crack], y)
    predicted = tree.predict([[x] for x in crack]).tolist() == words
    likely = tree.classes_[tree.predict_proba([[x] for x in crack]).argmax(axis=1)].tolist() == words
    return tree.objective_, tree.is_optimal_, tree.problem_.samples.class_order, predicted and likely


def asked_of_python(levels: tuple[str, ...], y: Any, **options: Any) -> tuple[float, bool, tuple[Any, ...]]:
    crack, _ = samples(levels)
    problem = Problem([[x] for x in crack], y, depth=2, monotone=[1], **options)
    found = solve(problem)
    return found.objective, found.is_optimal, problem.samples.class_order


def row(door: str, writer: str, case: str, make: Any, ask: Any, answer: Any) -> Row:
    return Row(door, writer, f"order of classes: {case}", make, ask, answer)


def at_solve(writer: str, name: str, *words: str, answer: Any = None) -> Row:
    """Return the row of `octmip solve` on a table of some levels, which are found in their order unless refused."""
    levels = LEVELS[name]
    case, right = " ".join((name, *words)), answer or (0, True, levels)
    return row("octmip solve TABLE", writer, case, written(writer, levels), lambda path: solved(path, *words), right)


def at_estimator(writer: str, name: str, make: Callable[[tuple[str, ...]], Any], **options: Any) -> Row:
    """Return the row of the classifier on labels of some levels; lists have no order of their own."""
    levels = LEVELS[name]
    right = (0.0, True, levels, True) if options or writer != "lists" else NO_ORDER
    case = " ".join((name, *options))
    ask = partial(fitted, levels, **options)
    return row("OptimalTreeClassifier", writer, case, lambda _: make(levels), ask, right)


def at_problem(writer: str, case: str, y: Any, answer: Any, **options: Any) -> Row:
    return row("Problem", writer, case, lambda _: y, partial(asked_of_python, LEVELS["wear"], **options), answer)


def labels(levels: tuple[str, ...]) -> list[str]:
    return samples(levels)[1]


def of_pandas(levels: tuple[str, ...]) -> Any:
    return pandas_frame(levels)["state"]


def of_polars(levels: tuple[str, ...]) -> Any:
    polars = pytest.importorskip("polars")
    return polars.Series(labels(levels), dtype=polars.Enum(levels))


WEAR = LEVELS["wear"]
NUMBERS = pd.Series([value for value in (1, 2.5, 3) for _ in range(ROWS_OF_EACH)], dtype=object)
ROWS: list[Row] = [
    *(at_solve(writer, name) for name in LEVELS for writer in ("pandas", "polars Enum", "pyarrow")),
    *(
        at_solve(writer, name, "--class-order", ",".join(levels))
        for name, levels in LEVELS.items()
        for writer in ("pandas csv", "polars Categorical")
    ),
    *(at_solve("pandas csv", name, answer=NO_ORDER) for name in LEVELS),
    at_solve(
        "pandas csv", "wear", "--class-order", "sound,failed", answer=Refused(("lacks 'worn'", "from low to high"))
    ),
    *(
        row(f"octmip {name}", "pandas csv", "check", written("pandas csv", LEVELS["check"]), other_command(name), True)
        for name in ("compare", "frontier")
    ),
    *(at_estimator("pandas Categorical", name, of_pandas) for name in LEVELS),
    at_estimator("polars Enum", "wear", of_polars),
    *(at_estimator("lists", name, labels) for name in LEVELS),
    *(at_estimator("lists", name, labels, class_order=levels) for name, levels in LEVELS.items()),
    at_problem("pandas Categorical", "wear", of_pandas(WEAR), (0.0, True, WEAR)),
    at_problem("lists", "wear, class_order", labels(WEAR), (0.0, True, WEAR), class_order=WEAR),
    at_problem("lists", "wear, class_names", labels(WEAR), (0.0, True, WEAR), class_names=WEAR),
    at_problem("lists", "wear, none", labels(WEAR), NO_ORDER),
    at_problem("pandas", "whole numbers beside others", NUMBERS, (0.0, True, (1, 2.5, 3))),
]
