"""Squared error beside pystreed and scikit-learn, one run, one thread: `python -m benchmarks.regression.peers`.

pystreed takes yes/no features: it makes quantile thresholds of every feature by its own option `n_thresholds`, and is
optimal among trees over these. It is no dependency of the project: the environment that this runs in must have it.
"""

import sys
import time
import warnings
from collections.abc import Iterator
from importlib.metadata import version

import numpy as np
import pandas as pd
import pystreed
from numpy.typing import NDArray
from sklearn.tree import DecisionTreeRegressor

from benchmarks.data import SHARED, published
from benchmarks.main_program import run_main
from benchmarks.regression.samples import made_up
from octmip import Limits, Problem, solve
from octmip.trees.losses import SquaredError

Floats = NDArray[np.float64]
SECONDS = 100.0
THRESHOLDS = (5, 20)
LARGE = 100_000


def sets() -> Iterator[tuple[str, Floats, Floats, tuple[int, ...]]]:
    """Yield name, features, targets and depths."""
    for name in ("winequality-white", "abalone"):
        frame = pd.read_csv(SHARED / "uci" / f"{name}.csv").dropna()
        targets = frame.pop("class").to_numpy(dtype=np.float64)
        yield name, pd.get_dummies(frame).to_numpy(dtype=np.float64), targets, (2, 3)
    table = published("mu2", 0)
    yield "published mu2", table.features, table.labels.astype(np.float64), (2, 3)
    yield "made up, 1,000,000 x 10", *made_up(1_000_000), (2,)


def rows(features: Floats, targets: Floats, depth: int) -> Iterator[tuple[str, float, float, str]]:
    """Yield who, squared error, CPU seconds and what is said of the tree."""
    start = time.process_time()
    solution = solve(Problem(features, targets, depth=depth, loss=SquaredError()), limits=Limits(seconds=SECONDS))
    gap = f"gap {100 * solution.gap:.2g} %" if solution.gap > 0 else "proven"
    yield "octmip", solution.objective, time.process_time() - start, gap
    peers = [("scikit-learn", DecisionTreeRegressor(max_depth=depth, random_state=0), "greedy")]
    for n in THRESHOLDS if len(features) <= LARGE else THRESHOLDS[:1]:
        options = {"max_depth": depth, "cost_complexity": 0.0, "n_thresholds": n, "time_limit": SECONDS}
        peers.append((f"pystreed, {n} thresholds", pystreed.STreeDRegressor(**options), "optimal on its thresholds"))
    for name, model, claim in peers:
        start = time.process_time()
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")
                predicted = np.asarray(model.fit(features, targets).predict(features), dtype=np.float64)
        except Exception as error:  # a peer's fault is a line of the table
            yield name, float("nan"), time.process_time() - start, f"{type(error).__name__}: {error}"[:60]
            continue
        yield name, float(((predicted.ravel() - targets) ** 2).sum()), time.process_time() - start, claim


def main() -> None:
    """Print the table as Markdown."""
    names = ("pystreed", "scikit-learn", "numpy")
    print(", ".join(f"{name} {version(name)}" for name in names), f"Python {sys.version.split()[0]}, one thread\n")
    print("| set | depth | who | squared error | CPU s | |\n|---|---|---|---|---|---|")
    for name, features, targets, depths in sets():
        for depth in depths:
            for who, error, seconds, claim in rows(features, targets, depth):
                print(f"| {name} | {depth} | {who} | {error:.9g} | {seconds:.2f} | {claim} |", flush=True)


if __name__ == "__main__":
    run_main(main)
