"""Local search under cost matrices beside the same search for errors: equal restarts and effort, several seeds."""

import statistics
from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from benchmarks.cpu import Stopwatch
from benchmarks.data import Table, published, uci
from benchmarks.tables import Line
from octmip.trees.losses import ClassCosts
from octmip.trees.methods.options import SearchOptions
from octmip.trees.methods.search import local_search
from octmip.trees.problem import Problem
from octmip.trees.solution import Limits

SEEDS = range(3)
DEPTHS = (2, 3, 4)
PERTURBATIONS = 8
"""Of one restart, the same for every matrix: a search that runs until nothing helps would compare luck."""


def tables() -> dict[str, Table]:
    """Return the sets: ordered classes, so that a distance of classes means something."""
    return {
        "published strains, mu2": published("mu2", 0),
        "published strains, mu1": published("mu1", 0),
        "winequality-white": uci("winequality-white"),
        "contraceptive-method-choice": uci("contraceptive-method-choice"),
    }


def matrices(n_classes: int) -> dict[str, NDArray[np.float64]]:
    """Return costs by name: errors, distances of classes, five times the cost across the middle, and random ones."""
    at = np.arange(n_classes)
    wrong = 1.0 - np.eye(n_classes)
    across = (at[:, None] < n_classes / 2) != (at[None, :] < n_classes / 2)
    drawn = np.random.default_rng(0).integers(1, 1000, (n_classes, n_classes)) * wrong
    return {
        "errors": wrong,
        "distances": np.abs(at[:, None] - at[None, :]).astype(float),
        "risk": np.where(across, 5.0, 1.0) * wrong,
        "random, 1 to 999": drawn,
    }


def results(limit: float, threads: Sequence[int]) -> Iterator[Line]:
    """Yield a line for each set, depth and matrix: the median CPU seconds over the seeds."""
    for name, table in tables().items():
        labels = np.unique(table.labels, return_inverse=True)[1]
        for depth in DEPTHS:
            for kind, costs in matrices(int(labels.max()) + 1).items():
                problem = Problem(table.features, labels, depth=depth, loss=ClassCosts(costs))
                seconds, objectives = [], []
                for seed in SEEDS:
                    watch = Stopwatch()
                    found = local_search(
                        problem,
                        seed=seed,
                        options=SearchOptions(restarts=1, perturbations=PERTURBATIONS),
                        limits=Limits(seconds=limit),
                    )
                    seconds.append(watch.read()[0])
                    objectives.append(found.objective)
                yield {
                    "size": f"{name}, depth {depth}",
                    "seed": 0,
                    "way": kind,
                    "cpu_seconds": round(statistics.median(seconds), 4),
                    "objectives": objectives,
                }


def summary(lines: Sequence[Line]) -> str:
    """Return the seconds of each matrix and how many times those for errors they are."""
    kinds = list(dict.fromkeys(line["way"] for line in lines))
    by_size: dict[str, dict[str, float]] = {}
    for line in lines:
        by_size.setdefault(line["size"], {})[line["way"]] = line["cpu_seconds"]
    rows = ["| case | " + " | ".join(kinds) + " |", "|---|" + "---|" * len(kinds)]
    ratios: dict[str, list[float]] = {}
    for size, found in by_size.items():
        cells = [f"{found['errors']:.3g}"]
        for kind in kinds[1:]:
            ratio = found[kind] / found["errors"]
            ratios.setdefault(kind, []).append(ratio)
            cells.append(f"{found[kind]:.3g} ({ratio:.2f})")
        rows.append(f"| {size} | " + " | ".join(cells) + " |")
    means = [f"{statistics.geometric_mean(values):.2f}" for values in ratios.values()]
    rows.append("| geometric mean of the ratio | | " + " | ".join(means) + " |")
    return "\n".join(rows)
