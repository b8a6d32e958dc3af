"""How long regression proofs take: the published strains, and samples by the million; scikit-learn's trees beside them.

`python -m benchmarks.run regression_speed --limit 100`. Figures are CPU seconds of one thread.
"""

import time
from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray
from sklearn.tree import DecisionTreeRegressor

from benchmarks.data import published
from benchmarks.tables import Line
from octmip.trees.answer.solution import Limits
from octmip.trees.question.losses import number_loss
from octmip.trees.question.problem import Problem
from octmip.trees.solver import solve

SIZES = (100_000, 1_000_000)


def results(limit: float, threads: Sequence[int]) -> Iterator[Line]:
    """Yield a line for each set, depth and loss."""
    for label in ("mu1", "mu2"):
        table = published(label, 0)
        for depth in (2, 3):
            for loss in ("squared", "absolute"):
                yield _line(f"published {label}", table.features, table.labels.astype(float), depth, loss, limit)
    for n in SIZES:
        features, targets = made_up(n)
        yield _line(f"made up, {n} x 10", features, targets, 2, "squared", limit)


def made_up(n: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return samples of a tree of depth 2 with a slope and noise."""
    rng = np.random.default_rng(0)
    features = rng.normal(size=(n, 10))
    inner = np.where(features[:, 0] > 0.3, 2.0 * (features[:, 1] > 0), features[:, 2] > -0.5)
    return features, inner + 0.3 * features[:, 3] + rng.normal(size=n)


def _line(
    name: str,
    features: NDArray[np.float64],
    targets: NDArray[np.float64],
    depth: int,
    loss: str,
    limit: float,
) -> Line:
    problem = Problem(features, targets, depth=depth, loss=number_loss(loss))
    start = time.process_time()
    solution = solve(problem, limits=Limits(seconds=limit))
    seconds, start = time.process_time() - start, time.process_time()
    criterion = "squared_error" if loss == "squared" else "absolute_error"
    greedy = DecisionTreeRegressor(max_depth=depth, criterion=criterion, random_state=0).fit(features, targets)
    greedy_seconds = time.process_time() - start
    misses = np.abs(greedy.predict(features) - targets)
    return {
        "size": f"{name}, depth {depth}, {loss} error",
        "seed": 0,
        "objective": solution.objective,
        "bound": solution.bound,
        "stop": str(solution.stop),
        "cpu_seconds": seconds,
        "n_nodes": solution.n_nodes,
        "scikit_learn": float((misses**2 if loss == "squared" else misses).sum()),
        "scikit_learn_cpu_seconds": greedy_seconds,
    }
