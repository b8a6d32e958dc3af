"""Readings of the published strains lost at random, and gauges that are dead at test time; mu1, MAE in percent.

`python -m benchmarks.run missing_strains --limit 60`: for each seed and depth a tree trained on readings of which
a fifth is lost, and one trained on all of them; both tested on full readings, and with each gauge that the tree reads
dead. A tree trained on full readings takes the heavier side then (`Problem.takes_missing`), or reads the mean of the
training, or the value that the other gauges predict (`octmip.sensing.Imputation`).
"""

import time
from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import partial

import numpy as np
from numpy.typing import NDArray

from benchmarks.data import SHARED
from benchmarks.tables import Line
from femlib.dataset import Dataset, Recipe, build_dataset, published_strains
from octmip.interfaces.report.markdown import markdown_table
from octmip.sensing import Imputation
from octmip.trees.problem import Problem
from octmip.trees.solution import Limits
from octmip.trees.solver import solve
from octmip.trees.tree import Node, features_used, predict

LOST = 0.2
SEEDS = range(5)
DEPTHS = (2, 3, 4)

Floats = NDArray[np.float64]


def results(limit: float, threads: Sequence[int]) -> Iterator[Line]:
    """Yield a line for each depth, seed and rule."""
    for seed in SEEDS:
        data = build_dataset(published_strains(SHARED / "uav" / "strains.csv"), Recipe(), seed=seed)
        for depth in DEPTHS:
            yield from _lines(data, depth, seed, Limits(seconds=limit), max(threads))


def _lines(data: Dataset, depth: int, seed: int, limits: Limits, n_threads: int) -> Iterator[Line]:
    full = Problem(data.features[data.is_train], data.mu1[data.is_train], depth=depth, takes_missing=True)
    is_lost = np.random.default_rng([20, seed]).random(full.features.shape) < LOST
    asked = {"full readings": full, "a fifth lost": replace(full, features=np.where(is_lost, np.nan, full.features))}
    for trained, problem in asked.items():
        start = time.perf_counter()
        solution = solve(problem, "exact", limits, n_jobs=n_threads)
        seconds = time.perf_counter() - start
        assert solution.tree is not None
        for rule, told in _rules(problem, solution.tree).items():
            yield {
                "size": f"depth {depth}, trained on {trained}, {rule}",
                "seed": seed,
                "depth": depth,
                "trained": trained,
                "rule": rule,
                "objective": solution.objective,
                "is_optimal": solution.is_optimal,
                "mae": _error(problem, told(data.features[~data.is_train]), data),
                **_with_dead_gauges(problem, solution.tree, told, data),
                "seconds": seconds,
            }


def _rules(problem: Problem, tree: Node) -> dict[str, "partial[NDArray[np.int64]]"]:
    """Return how a tree answers where readings are missing, by name."""
    if problem.n_missing:
        return {"its own sides": partial(predict, tree)}
    means = problem.features.mean(axis=0)
    return {
        "the heavier side": partial(predict, tree),
        "means of the training": partial(_filled, tree, means),
        "imputed from the others": partial(_imputed, tree, Imputation.fit(problem.features)),
    }


def _filled(tree: Node, means: Floats, features: Floats) -> NDArray[np.int64]:
    return predict(tree, np.where(np.isnan(features), means, features))


def _imputed(tree: Node, imputation: Imputation, features: Floats) -> NDArray[np.int64]:
    return predict(tree, imputation.impute(features))


def _error(problem: Problem, codes: NDArray[np.int64], data: Dataset) -> float:
    """Return the mean absolute error on the test samples."""
    levels = np.array(problem.class_names, dtype=np.float64)
    return float(np.abs(levels[codes] - data.mu1[~data.is_train]).mean())


def _with_dead_gauges(
    problem: Problem, tree: Node, told: "partial[NDArray[np.int64]]", data: Dataset
) -> dict[str, float]:
    """Return the mean and the worst error over the gauges of the tree, each dead in all test samples in its turn."""
    errors = []
    for gauge in features_used(tree):
        features = data.features[~data.is_train].copy()
        features[:, gauge] = np.nan
        errors.append(_error(problem, told(features), data))
    return {"mae_dead_mean": float(np.mean(errors)), "mae_dead_worst": max(errors)}


def summary(lines: Sequence[Line]) -> str:
    """Return the means over the seeds as a table."""
    kinds = sorted({(line["depth"], line["trained"], line["rule"]) for line in lines})
    rows = []
    for depth, trained, rule in kinds:
        of_kind = [line for line in lines if (line["depth"], line["trained"], line["rule"]) == (depth, trained, rule)]
        named = {"mae": "full test", "mae_dead_mean": "one dead, mean", "mae_dead_worst": "one dead, worst"}
        means = {shown: float(np.mean([line[name] for line in of_kind])) for name, shown in named.items()}
        seconds = max(line["seconds"] for line in of_kind)
        proven = sum(line["is_optimal"] for line in of_kind)
        rows.append(
            {"depth": depth, "trained on": trained, "where a reading is missing": rule}
            | {name: f"{value:.2f}" for name, value in means.items()}
            | {"proven": f"{proven} of {len(of_kind)}", "s at most": f"{seconds:.1f}"}
        )
    return markdown_table(rows)
