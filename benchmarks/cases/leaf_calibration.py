"""Are leaf probabilities those of fresh rows? Expected calibration error of proven trees of depth 3, two ways.

The published strains by the study's recipe (1,750 rows, and 20,000), judged by 50,000 fresh readings, and public
tables: 500 rows or half of them train, the others judge. The kind of correction and its folds were chosen with seeds 0
to 27 of the strains and 0 to 14 of the tables in view; from seed 30 on nothing was looked at before.
"""

import time
from collections.abc import Iterator

import numpy as np

from benchmarks.data import SHARED, uci
from benchmarks.tables import Line, markdown
from femlib.dataset import Recipe, build_dataset, published_strains
from octmip import Limits, Problem, solve
from octmip.trees.tradeoff import leaves_on_fresh_rows
from octmip.trees.uncertainty import LeafDistribution

FIRST_SEED, N_SEEDS = 30, 12
LARGE = "mu2, 20,000 rows"
STRAINS = {"mu1": 100, "mu2": 100, LARGE: 1143}
"""Readings of each state, of which 70 % train."""
TABLES = (
    "winequality-white",
    "spambase",
    "contraceptive-method-choice",
    "pen-based-recognition-digits",
    "ct-bank",
    "ct-magic",
    "ct-bidding",
    "ct-wilt",
    "mammography",
    "ct-htru",
    "ct-room",
    "ct-occupancy",
)
FRESH_PER_STATE = 2000


def results(limit: float, threads: list[int]) -> Iterator[Line]:
    """Yield one line for each set and seed; `limit` [s] is that of every solve."""
    for name in (*STRAINS, *TABLES):
        for seed in range(FIRST_SEED, FIRST_SEED + (N_SEEDS if name in STRAINS and name != LARGE else 3)):
            yield _line(name, seed, Limits(seconds=limit), threads[0])


def _line(name: str, seed: int, limits: Limits, threads: int) -> Line:
    train, truth, fresh, hits = _samples(name, seed)
    problem = Problem(train, truth, depth=3)
    known = np.isin(hits, problem.class_names)
    fresh, codes = fresh[known], np.searchsorted(problem.class_names, hits[known])
    solution = solve(problem, "exact", limits, n_jobs=threads)
    assert solution.tree is not None
    plain = LeafDistribution.of(solution.tree, problem)
    start = time.process_time()
    corrected = leaves_on_fresh_rows(problem, solution.tree, seed=seed, n_jobs=threads)
    seconds = time.process_time() - start
    line: Line = {"case": name, "seed": seed, "is_optimal": solution.is_optimal, "n_fresh": len(codes)}
    line["cpu_seconds"] = seconds
    for way, leaves in (("training", plain), ("corrected", corrected)):
        table = leaves.predict(fresh)
        line[f"ece_{way}"] = calibration_error(table, codes)
        line[f"brier_{way}"] = float(np.square(table - np.eye(table.shape[1])[codes]).sum(axis=1).mean())
        line[f"claimed_{way}"] = float(table.max(axis=1).mean())
        line["right"] = float((table.argmax(axis=1) == codes).mean())
    return line


def calibration_error(table: np.ndarray, codes: np.ndarray) -> float:
    """Return the expected calibration error of probabilities (n, n_classes) over ten bins of the greatest in each row.

    Source: M. P. Naeini, G. F. Cooper, M. Hauskrecht, Obtaining well calibrated probabilities using Bayesian binning
    (2015).
    """
    given, is_hit = table.max(axis=1), table.argmax(axis=1) == codes
    bins = np.clip(np.ceil(given * 10).astype(int) - 1, 0, 9)
    return float(np.abs(np.bincount(bins, given - is_hit)).sum() / len(codes))


def _samples(name: str, seed: int) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Return features and labels to train on, features and labels to judge by."""
    if name in STRAINS:
        means = published_strains(SHARED / "uav" / "strains.csv")
        data = build_dataset(means, Recipe(samples_per_state=STRAINS[name]), seed=seed)
        fresh = build_dataset(means, Recipe(samples_per_state=FRESH_PER_STATE), seed=seed + 1000)
        label = name[:3]
        return data.features[data.is_train], getattr(data, label)[data.is_train], fresh.features, getattr(fresh, label)
    table = uci(name)
    order = np.random.default_rng(seed).permutation(len(table.labels))
    train, rest = np.split(order, [min(len(order) // 2, 500)])
    return table.features[train], table.labels[train], table.features[rest], table.labels[rest]


def summary(lines: list[Line]) -> str:
    """Return means over the seeds as a table in Markdown."""
    two = "training / corrected"
    rows = []
    for name in dict.fromkeys(line["case"] for line in lines):
        mine = [line for line in lines if line["case"] == name]

        def mean(key: str, mine: list[Line] = mine) -> float:
            return float(np.mean([line[key] for line in mine]))

        pairs = [f"{mean(f'{k}_training'):.4f} / {mean(f'{k}_corrected'):.4f}" for k in ("claimed", "ece", "brier")]
        rows.append([name, pairs[0], f"{mean('right'):.4f}", *pairs[1:], f"{mean('cpu_seconds'):.2f}"])
    return markdown(["set", f"claimed, {two}", "right", f"ECE, {two}", f"Brier, {two}", "CPU s"], rows)
