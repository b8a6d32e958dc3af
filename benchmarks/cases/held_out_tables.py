"""Which tree holds on new rows? Every table of ../shared/uci, five folds repeated twice, our default beside its rivals.

Each learner trains on four folds and is judged on the fifth. Rows, columns and encoding are the same for all: text as
yes/no columns, missing numbers as they are (the linear model has their medians, and scaled columns).

The constants of the default (families, cuts, the rule of half a standard error) were settled on the tables of odd
number in alphabetical order, so the others are the score. The order of the runs is: the first fold of every even table,
then of every odd one, by rising size of their files; then the next fold. Every line is added to a CSV as soon as it is
known and not made again, so the run may be stopped at any time.
"""

import csv
import importlib.util
import time
import warnings
from collections.abc import Callable, Iterator, Mapping
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from sklearn.ensemble import HistGradientBoostingClassifier, RandomForestClassifier
from sklearn.impute import SimpleImputer
from sklearn.linear_model import LogisticRegression
from sklearn.model_selection import StratifiedKFold
from sklearn.pipeline import make_pipeline
from sklearn.preprocessing import StandardScaler
from sklearn.tree import DecisionTreeClassifier

from benchmarks.public_tables import SECONDS, CartOfLeaves, PrunedCart, TunedStreed, grid_cart, ordered, samples
from benchmarks.tables import Line, markdown
from octmip import OptimalTreeClassifier

CSV = Path(__file__).parents[2] / "docs" / "results" / "data" / "tables" / "held-out.csv"
FIELDS = (
    *("table", "half", "repeat", "fold", "learner", "rows", "columns", "classes", "errors", "tested", "leaves"),
    *("cpu_seconds", "kind", "expected", "expected_low", "expected_high"),
)


def linear_model() -> Any:
    """Return logistic regression of scaled columns."""
    return make_pipeline(SimpleImputer(strategy="median"), StandardScaler(), LogisticRegression(max_iter=2000))


LEARNERS: Mapping[str, Callable[[], Any]] = {
    "octmip": partial(OptimalTreeClassifier, seconds=SECONDS),
    "CART, pruned": PrunedCart,
    "CART, grid": grid_cart,
    "CART": partial(DecisionTreeClassifier, random_state=0),
    "proven, depth 3": partial(OptimalTreeClassifier, 3, seconds=20.0),
    "forest": partial(RandomForestClassifier, 200, random_state=0),
    "boosting": partial(HistGradientBoostingClassifier, early_stopping=False, random_state=0),
    "linear": linear_model,
}

STREED = "STreeD, depth 3"
"""Where pystreed is installed: the extra `benchmarks`."""
if importlib.util.find_spec("pystreed"):
    LEARNERS = {**LEARNERS, STREED: TunedStreed}

AS_SMALL = "CART, as small"
"""Pruned to as many leaves as the default has on the same fold."""


def results(limit: float, threads: list[int], only: str = "") -> Iterator[Line]:
    """Yield the lines that the CSV lacks, and add them to it; `only` is part of a table's name.

    The limit and the threads have no effect: every learner has one thread and its own limit.
    """
    done = {tuple(row[name] for name in FIELDS[:5]): row for row in rows()}
    for repeat, fold in ((r, f) for r in range(2) for f in range(5)):
        for table, half in ordered():
            key = (table, half, str(repeat), str(fold))
            lacking = [name for name in (*LEARNERS, AS_SMALL) if (*key, name) not in done]
            if lacking and only in table:
                of_ours = done.get((*key, "octmip"), {})
                for line in _judged(table, repeat, fold, lacking, of_ours.get("leaves")):
                    line = {"table": table, "half": half, "repeat": repeat, "fold": fold, **line}
                    _add(line)
                    yield {"size": table, "seed": repeat, **line}


def rows() -> list[dict[str, str]]:
    """Return the lines of the CSV."""
    if not CSV.exists():
        return []
    with CSV.open(newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


def _add(line: Line) -> None:
    is_new = not CSV.exists()
    with CSV.open("a", newline="", encoding="utf-8") as file:
        table = csv.DictWriter(file, FIELDS)
        if is_new:
            table.writeheader()
        table.writerow(line)


def _judged(table: str, repeat: int, fold: int, learners: list[str], n_leaves: str | int | None) -> Iterator[Line]:
    """Yield a line of each learner; `n_leaves` of the default, where it is not among them."""
    X, y = samples(table)
    folds = StratifiedKFold(5, shuffle=True, random_state=repeat)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # classes of few rows, limits, separable classes
        train, test = list(folds.split(X, y))[fold]
        for name in learners:
            start = time.process_time()
            learner = CartOfLeaves(int(n_leaves or 1)) if name == AS_SMALL else LEARNERS[name]()
            learner.fit(X[train], y[train])
            seconds = time.process_time() - start
            errors = int((learner.predict(X[test]) != y[test]).sum())
            line: Line = {"learner": name, "rows": len(y), "columns": X.shape[1], "classes": len(np.unique(y))}
            line |= {"errors": errors, "tested": len(test), "cpu_seconds": round(seconds, 3), **_said(learner)}
            n_leaves = line["leaves"] if name == "octmip" else n_leaves
            yield line


def _said(learner: Any) -> Line:
    """Return leaves, and of a default the kind that was chosen and the error that is expected."""
    tree = getattr(learner, "tree", learner)
    found: Line = {"leaves": int(tree.get_n_leaves()) if hasattr(tree, "get_n_leaves") else ""}
    choice = getattr(learner, "choice_", None)
    if choice is not None:
        expected = choice.expectation.tree
        found |= {"kind": choice.chosen.kind, "expected": round(expected.mean, 5)}
        found |= {"expected_low": round(expected.low, 5), "expected_high": round(expected.high, 5)}
    return found


def summary(_: list[Line]) -> str:
    """Return the table of means of the CSV, over all tables that have a line of every learner, by half."""
    frame = pd.DataFrame(rows()).astype({"errors": int, "tested": int, "cpu_seconds": float})
    frame["error"] = frame.errors / frame.tested
    frame["leaves"] = pd.to_numeric(frame.leaves)
    whole = frame.groupby(["table", "half", "learner"])[["error", "leaves", "cpu_seconds"]].mean().reset_index()
    n_tables = whole.groupby("learner").table.nunique()
    learners = [name for name in (*LEARNERS, AS_SMALL) if n_tables.get(name, 0) == n_tables["octmip"]]
    whole = whole[whole.learner.isin(learners)]
    whole = whole[whole.groupby("table").learner.transform("count") == len(learners)]
    parts = []
    for half in ("even", "odd"):
        part = whole[whole.half == half]
        if part.empty:
            continue
        error = part.pivot_table(index="table", columns="learner", values="error")[learners]
        cells = []
        for name in learners:
            of = part[part.learner == name]
            behind = int((error["octmip"] > error[name] + 0.01).sum())
            ahead = int((error["octmip"] < error[name] - 0.01).sum())
            leaves = "" if of.leaves.isna().all() else f"{of.leaves.mean():.1f}"
            cells.append([name, f"{100 * of.error.mean():.2f}", leaves, f"{of.cpu_seconds.mean():.2f}", behind, ahead])
        head = ["learner", "error %", "leaves", "CPU s", "below ours by 1 point on", "above"]
        parts.append(f"{len(error)} tables of the {half} half\n\n{markdown(head, cells)}")
    return "\n\n".join([*parts, _differences(frame)])


def _differences(frame: pd.DataFrame) -> str:
    """Return by how much the default errs less than CART on the folds that have both, by half and number of classes."""
    cells = []
    for name in ("CART, pruned", AS_SMALL):
        pair = frame[frame.learner.isin(["octmip", name])]
        pair = pair.pivot_table(index=["table", "half", "classes", "repeat", "fold"], columns="learner", values="error")
        less = (pair["octmip"] - pair[name]).dropna().groupby(["table", "half", "classes"]).agg(["mean", "count"])
        less = less.reset_index()
        more = pd.to_numeric(less.classes) > 2
        for half in ("even", "odd"):
            for words, is_in in (("2", ~more), ("3 and more", more), ("any", more | ~more)):
                part = less[is_in & (less.half == half)]
                points, n = 100 * part["mean"], len(part)
                if n > 1:
                    error = points.std() / np.sqrt(n)
                    n_folds = part["count"].sum()
                    cells.append([name, half, words, n, n_folds, f"{points.mean():+.2f}", f"{error:.2f}"])
    return markdown(["default less", "half", "classes", "tables", "folds", "points", "standard error"], cells)
