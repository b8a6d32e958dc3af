"""What models without a tree make of the gauges, beside the trees of the study.

All twenty gauges, the training and test readings of the study. The levels of damage are five classes; a straight line
predicts a number, which is rounded to the nearest level.
"""

from collections.abc import Sequence

import numpy as np
from joblib import Parallel, delayed
from numpy.typing import NDArray

from benchmarks.tables import markdown
from benchmarks.uav.study import LABELS
from femlib.dataset import Dataset
from octmip import Problem
from octmip.trees.answer.solution import Limits
from octmip.trees.nodes.tree import leaves, predict
from octmip.trees.runs.registry import Run
from octmip.trees.tradeoff.baselines import baselines_of
from octmip.trees.tradeoff.default import solve_default

HEADER = ("label", "model", "errors train %", "errors test %", "MAE train", "MAE test")


def rows_of(data: Dataset, seed: int, seconds: float, n_jobs: int) -> list[dict[str, object]]:
    """Return a row for each label and model; `seconds` [s] limits the choice of the default tree."""
    found = Parallel(n_jobs=n_jobs)(delayed(_rows_of_label)(data, label, seed, seconds) for label in LABELS)
    return [row for rows in found for row in rows]


def _rows_of_label(data: Dataset, label: str, seed: int, seconds: float) -> list[dict[str, object]]:
    levels = getattr(data, label)
    problem = Problem(data.features[data.is_train], levels[data.is_train], depth=1)
    rows = [
        _row(data, label, problem, name, train(seed)(data.features)) for name, train in baselines_of(problem).items()
    ]
    tree = solve_default(problem, Run("auto", Limits(seconds=seconds), seed)).solution.tree
    default = f"octmip's default, {len(leaves(tree))} leaves"
    return [*rows, _row(data, label, problem, default, predict(tree, data.features))]


def _row(data: Dataset, label: str, problem: Problem, name: str, codes: NDArray[np.int64]) -> dict[str, object]:
    levels = getattr(data, label)
    misses = np.abs(np.array(problem.samples.class_names, dtype=float)[codes] - levels)
    row: dict[str, object] = {"label": label, "model": name}
    for part, rows in (("train", data.is_train), ("test", ~data.is_train)):
        row[f"error_{part}"] = float((misses[rows] > 0).mean())
        row[f"mae_{part}"] = float(misses[rows].mean())
    return row


def text_of(rows: Sequence[dict[str, object]]) -> str:
    """Return the table, MAE in percent loss of stiffness."""
    cells = []
    for row in rows:
        errors = [f"{100 * float(str(row[f'error_{part}'])):.1f}" for part in ("train", "test")]
        maes = [f"{row[f'mae_{part}']:.2f}" for part in ("train", "test")]
        cells.append([row["label"], row["model"], *errors, *maes])
    return f"# Models without a tree\n\nMAE in percent loss of stiffness; all gauges.\n\n{markdown(HEADER, cells)}\n"
