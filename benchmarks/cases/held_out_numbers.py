"""Which tree of numbers holds on new rows? Columns of the tables of ../shared/uci as targets, two of five folds.

The target of a table is its column of most values. The default is judged beside CART, pruned by cross-validation. An
error is the mean squared error on the fold, by that of the mean of the training rows. The rule of the default for
numbers was settled on the tables of odd number in alphabetical order.
"""

import time
import warnings
from collections.abc import Callable, Iterator, Mapping
from functools import partial
from typing import Any

import numpy as np
import pandas as pd
from sklearn.model_selection import KFold

from benchmarks.public_tables import SECONDS, PrunedCart, numbers, ordered
from benchmarks.tables import Line, markdown
from octmip import OptimalTreeRegressor

N_FOLDS = 2
LEARNERS: Mapping[str, Callable[[], Any]] = {
    "octmip": partial(OptimalTreeRegressor, seconds=SECONDS),
    "CART, pruned": partial(PrunedCart, is_class=False),
}


def results(limit: float, threads: list[int], only: str = "") -> Iterator[Line]:
    """Yield a line for each table, fold and learner; the limit and the threads have no effect."""
    for table, half in ordered():
        asked = numbers(table) if only in table else None
        if asked is None:
            continue
        X, y = asked
        for fold, (train, test) in list(enumerate(KFold(5, shuffle=True, random_state=1).split(X)))[:N_FOLDS]:
            by_mean = float(((y[test] - y[train].mean()) ** 2).mean())
            for name, learner in LEARNERS.items():
                start = time.process_time()
                with warnings.catch_warnings():
                    warnings.simplefilter("ignore")  # limits
                    found = learner().fit(X[train], y[train])
                seconds = time.process_time() - start
                error = float(((found.predict(X[test]) - y[test]) ** 2).mean()) / by_mean
                line = {"size": table, "half": half, "seed": fold, "learner": name, "rows": len(y), "error": error}
                leaves = int(getattr(found, "tree", found).get_n_leaves())
                yield line | {"leaves": leaves, "cpu_seconds": round(seconds, 3)}


def summary(lines: list[Line]) -> str:
    """Return the mean error by half and learner, and by how many per cent the default errs less in the mean."""
    frame = pd.DataFrame(lines).pivot_table(
        index=["half", "size"], columns="learner", values=["error", "leaves", "cpu_seconds"]
    )
    rows, ratios = [], []
    for half, part in frame.groupby("half"):
        means = part.mean()
        for name in LEARNERS:
            digits = {"error": 3, "leaves": 1, "cpu_seconds": 2}
            rows.append([half, len(part), name, *(f"{means[what, name]:.{n}f}" for what, n in digits.items())])
        ratio = np.log(part["error", "octmip"] / part["error", "CART, pruned"])
        ratios.append(f"{half}: log of the ratio {ratio.mean():+.3f} +- {ratio.std() / len(ratio) ** 0.5:.3f}")
    return "\n".join([markdown(["half", "tables", "learner", "error", "leaves", "CPU s"], rows), "", *ratios])
