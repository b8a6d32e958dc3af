"""Doors that take `monotone`: the order of the classes is the one that the other program says, or is asked for."""

import json
from collections.abc import Callable
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
    return tree.objective_, tree.is_optimal_, tree.problem_.class_order, predicted and likely


def asked_of_python(levels: tuple[str, ...], y: Any, **options: Any) -> tuple[float, bool, tuple[Any, ...]]:
    crack, _ = samples(levels)
    problem = Problem([[x] for x in crack], y, depth=2, monotone=[1], **options)
    found = solve(problem)
    return found.objective, found.is_optimal, problem.class_order


def row(door: str, writer: str, case: str, make: Any, ask: Any, answer: Any) -> Row:
    return Row(door, writer, f"order of classes: {case}", make, ask, answer)


ROWS: list[Row] = [
    *(
        row("octmip solve TABLE", writer, name, written(writer, levels), solved, (0, True, levels))
        for name, levels in LEVELS.items()
        for writer in ("pandas", "polars Enum", "pyarrow")
    ),
    *(
        row(
            "octmip solve TABLE",
            writer,
            f"{name}, given",
            written(writer, levels),
            lambda path, levels=levels: solved(path, "--class-order", ",".join(levels)),
            (0, True, levels),
        )
        for name, levels in LEVELS.items()
        for writer in ("pandas csv", "polars Categorical")
    ),
    *(
        row("octmip solve TABLE", "pandas csv", f"{name}, none", written("pandas csv", levels), solved, NO_ORDER)
        for name, levels in LEVELS.items()
    ),
    row(
        "octmip solve TABLE",
        "pandas csv",
        "one class left out",
        written("pandas csv", LEVELS["wear"]),
        lambda path: solved(path, "--class-order", "sound,failed"),
        Refused(("lacks 'worn'", "from low to high")),
    ),
    *(
        row(f"octmip {name}", "pandas csv", "check", written("pandas csv", LEVELS["check"]), other_command(name), True)
        for name in ("compare", "frontier")
    ),
    *(
        row(
            "OptimalTreeClassifier",
            "pandas Categorical",
            name,
            lambda _, levels=levels: pandas_frame(levels)["state"],
            lambda y, levels=levels: fitted(levels, y),
            (0.0, True, levels, True),
        )
        for name, levels in LEVELS.items()
    ),
    row(
        "OptimalTreeClassifier",
        "polars Enum",
        "wear",
        lambda _: pytest.importorskip("polars").Series(
            samples(LEVELS["wear"])[1], dtype=pytest.importorskip("polars").Enum(LEVELS["wear"])
        ),
        lambda y: fitted(LEVELS["wear"], y),
        (0.0, True, LEVELS["wear"], True),
    ),
    *(
        row(
            "OptimalTreeClassifier",
            "lists",
            f"{name}, {'given' if given else 'none'}",
            lambda _, levels=levels: samples(levels)[1],
            lambda y, levels=levels, given=given: fitted(levels, y, class_order=levels if given else None),
            (0.0, True, levels, True) if given else NO_ORDER,
        )
        for name, levels in LEVELS.items()
        for given in (True, False)
    ),
    *(
        row(
            "Problem",
            writer,
            f"wear, {how}",
            lambda _, y=y: y,
            lambda y, options=options: asked_of_python(LEVELS["wear"], y, **options),
            (0.0, True, LEVELS["wear"]) if how != "none" else NO_ORDER,
        )
        for writer, how, y, options in (
            ("pandas Categorical", "its own", pandas_frame(LEVELS["wear"])["state"], {}),
            ("lists", "class_order", samples(LEVELS["wear"])[1], {"class_order": LEVELS["wear"]}),
            ("lists", "class_names", samples(LEVELS["wear"])[1], {"class_names": LEVELS["wear"]}),
            ("lists", "none", samples(LEVELS["wear"])[1], {}),
        )
    ),
    row(
        "Problem",
        "lists",
        "whole numbers beside others",
        lambda _: [value for value in (1, 2.5, 3) for _ in range(ROWS_OF_EACH)],
        lambda y: asked_of_python(LEVELS["wear"], pd.Series(y, dtype=object)),
        (0.0, True, (1, 2.5, 3)),
    ),
]
