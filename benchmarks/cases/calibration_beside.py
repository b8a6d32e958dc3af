"""Is a share what comes true? Calibration error on new rows: the default's leaves, pruned CART's leaves, a forest.

Ten public tables; 1,000 rows at most, or half of them, train, and the others judge. The error is the expected
calibration error of all classes (`octmip.trees.uncertainty.calibration_error`); the Brier score is beside it, as shares
that say nothing are calibrated too.
"""

import time
import warnings
from collections.abc import Iterator
from typing import Any

import numpy as np
from sklearn.ensemble import RandomForestClassifier

from benchmarks.public_tables import PrunedCart, samples
from benchmarks.tables import Line, markdown
from octmip import OptimalTreeClassifier
from octmip.trees.uncertainty import brier_score, calibration_error

TABLES = (
    "banknote-authentication",
    "car-evaluation",
    "contraceptive-method-choice",
    "ct-wilt",
    "mammographic-mass",
    "pima-diabetes",
    "spambase",
    "statlog-german-credit",
    "tic-tac-toe-endgame",
    "winequality-white",
)
MOST_TRAINING = 1000
LEARNERS = ("octmip", "CART, pruned", "forest")


def results(limit: float, threads: list[int]) -> Iterator[Line]:
    """Yield one line for each table and learner; `limit` [s] is the default's."""
    for table in TABLES:
        X, y = samples(table)
        order = np.random.default_rng(0).permutation(len(y))
        train, rest = np.split(order, [min(len(order) // 2, MOST_TRAINING)])
        rest = rest[np.isin(y[rest], y[train])]
        for name in LEARNERS:
            start = time.process_time()
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")  # classes of few rows, limits
                model = _model(name, limit, threads[0]).fit(X[train], y[train])
            seconds = time.process_time() - start
            model = getattr(model, "tree", model)
            shares = model.predict_proba(X[rest])
            codes = np.searchsorted(model.classes_, y[rest])
            line: Line = {"case": table, "seed": 0, "learner": name, "n_training": len(train), "n_new": len(rest)}
            line |= {"ece": calibration_error(shares, codes), "brier": brier_score(shares, codes).score}
            line |= {"wrong": float((shares.argmax(axis=1) != codes).mean()), "cpu_seconds": seconds}
            yield line


def _model(name: str, limit: float, threads: int) -> Any:
    if name == "octmip":
        return OptimalTreeClassifier(seconds=limit, n_jobs=threads)
    return PrunedCart() if name == "CART, pruned" else RandomForestClassifier(200, random_state=0)


def summary(lines: list[Line]) -> str:
    """Return the errors of each table and their means as a table in Markdown."""
    rows = []
    for table in dict.fromkeys(line["case"] for line in lines):
        mine = [line for line in lines if line["case"] == table]
        rows.append([table, mine[0]["n_new"], _figures(mine, "ece", 100), _figures(mine, "brier", 1)])
    rows.append(["mean", "", _figures(lines, "ece", 100), _figures(lines, "brier", 1)])
    head = ["table", "new rows", "calibration error %", "Brier score"]
    return f"{' / '.join(LEARNERS)}\n\n{markdown(head, rows)}"


def _figures(lines: list[Line], key: str, scale: float) -> str:
    means = [np.mean([float(line[key]) for line in lines if line["learner"] == name]) for name in LEARNERS]
    return " / ".join(f"{scale * mean:.{1 if scale > 1 else 3}f}" for mean in means)
