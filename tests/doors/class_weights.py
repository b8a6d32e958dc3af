"""Doors that take weights of classes, one answer for every row, and baselines of columns in any unit."""

import json
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from octmip import OptimalTreeClassifier, Problem
from octmip.trees.tradeoff.baselines import baselines_of
from tests.doors.row import Refused, Row, command

LABELS = ["no"] * 18 + ["yes"] * 2
READINGS = [*range(18), 12.5, 14.5]
"""Two rare rows among two others: a tree of depth 1 that counts rows alike calls all rows no."""
UNITS = {"1e-8": (0.0, 1e-8), "1e9 + 1e-5": (1e9, 1e-5), "1e300": (0.0, 1e300)}


def table(folder: Path) -> Path:
    path = folder / "rare.csv"
    pd.DataFrame({"x": READINGS, "y": LABELS}).to_csv(path, index=False)
    return path


def solved(path: Path, words: tuple[str, ...]) -> Any:
    asked = ("solve", path, "--label", "y", "--depth", "1", *words)
    tree = path.parent / "tree.json"
    found = json.loads(command(*asked, "--json", "--out", tree))
    command("certify", tree, path)
    return found["objective"], found["errors"]


def fitted(class_weight: Any) -> tuple[float, int]:
    features = [[x] for x in READINGS]
    tree = OptimalTreeClassifier(1, class_weight=class_weight).fit(features, LABELS)
    return tree.objective_, int((tree.predict(features) != LABELS).sum())


def wrong_of_baselines(unit: tuple[float, float]) -> int:
    """Return how many of 50 rows any baseline calls wrong where one cut parts the classes."""
    order = np.random.default_rng(0).permutation(50)
    problem = Problem((unit[0] + unit[1] * order)[:, None], (order > 24).astype(int), depth=1)
    return sum(
        int((train(0)(problem.samples.features) != problem.samples.codes).sum())
        for train in baselines_of(problem).values()
    )


def says_its_one_answer(path: Path) -> bool:
    said = command("solve", path, "--label", "y", "--depth", "1")
    return "answers no for every row" in said and "--class-weight balanced" in said


def weighted(words: str, given: Any) -> Row:
    """Return the row of --class-weight, whose answer is the estimator's."""
    ask = partial(solved, words=("--class-weight", words))
    return Row("octmip solve TABLE", "pandas csv", f"--class-weight {words}", table, ask, lambda _: fitted(given))


ROWS: list[Row] = [
    weighted("balanced", "balanced"),
    weighted("yes=9", {"yes": 9}),
    weighted("no=1,yes=9", {"no": 1, "yes": 9}),
    Row(
        "octmip solve TABLE",
        "pandas csv",
        "--class-weight of no class",
        table,
        partial(solved, words=("--class-weight", "maybe=2")),
        Refused(("--class-weight", "maybe", "which no row has")),
    ),
    Row("octmip solve TABLE", "pandas csv", "one answer for every row", table, says_its_one_answer, True),
    *(
        Row("octmip compare --baselines", "numpy", f"unit {name}", lambda _, unit=unit: unit, wrong_of_baselines, 0)
        for name, unit in UNITS.items()
    ),
]
