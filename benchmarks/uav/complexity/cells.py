"""The cells of the complexity study: one tree each, and its errors on unseen readings."""

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from itertools import product
from typing import Literal

import numpy as np

from benchmarks.cpu import cpu_seconds
from benchmarks.problem_options import ProblemOptions
from benchmarks.tables import Line
from benchmarks.uav.bayes import BayesLimit, bayes_limit
from benchmarks.uav.study import best_pair
from femlib.dataset import Dataset, MeanStrains, Recipe, build_dataset
from octmip import Problem, certify, predict
from octmip.trees.losses import ClassCosts
from octmip.trees.methods.options import SearchOptions
from octmip.trees.methods.search import EFFORT
from octmip.trees.registry import Method
from octmip.trees.solver import solve

Objective = Literal["errors", "mae"]

LABELS = ("mu1", "mu2")
DEPTHS = (3, 4, 5, 6)
SPLIT_SIZES = (1, 2, 4, None)  # features in one split; None: no limit
OBJECTIVES: tuple[Objective, ...] = ("errors", "mae")
SHARE = 5
"""Restarts of an axis-aligned tree, or of one for mu1, for each one of a hyperplane tree for mu2: they are shorter."""
DEEPEST_AXIS_MAE = 4
"""Exact subtrees of three levels take the exact core 40 to 230 times longer under a cost matrix than for errors, so an
axis-aligned search for the MAE of mu2 takes 11 CPU seconds at depth 4 and over a minute at depth 6."""


@dataclass(frozen=True, slots=True)
class Cell:
    """One tree that is asked for.

    Attributes
    ----------
    label
        "mu1" or "mu2".
    gauge_set
        "all" twenty, or "two": gauges 1 and 2 for mu1 as in the paper, the best pair for mu2.
    depth
        levels of splits.
    split_size
        features in one split; None: no limit.
    objective
        what it is trained for, "errors" as in the paper or "mae" by the cost matrix |mu_i - mu_k|.
    seed
        of readings and search.
    """

    label: str
    gauge_set: str
    depth: int
    split_size: int | None
    objective: Objective
    seed: int


def study_cells(seeds: Sequence[int], objectives: Sequence[Objective] = OBJECTIVES) -> list[Cell]:
    """Return the study's grid, seed by seed, so that a run that is cut short has whole seeds."""
    grid = product(seeds, objectives, LABELS, SPLIT_SIZES, DEPTHS)
    cells = [Cell(label, "all", depth, size, objective, seed) for seed, objective, label, size, depth in grid]
    return [cell for cell in cells if not _is_too_slow(cell)]


def paper_cells(seeds: Sequence[int]) -> list[Cell]:
    """Return the cells that the paper gives figures for, and the axis-aligned ones that they are compared with."""
    trees = (
        *(("mu1", "two", 3, size) for size in (1, 2)),
        *(("mu2", "two", 3, size) for size in (1, 2)),
        ("mu1", "all", 4, 2),
        *(("mu2", "all", 3, size) for size in SPLIT_SIZES),
        ("mu2", "all", 6, None),
    )
    cells = [Cell(*tree, objective, seed) for seed in seeds for tree in trees for objective in OBJECTIVES]
    return sorted(cells, key=lambda cell: (cell.seed, cell.gauge_set, cell.label))


def _is_too_slow(cell: Cell) -> bool:
    return cell.split_size == 1 and cell.objective == "mae" and cell.depth > DEEPEST_AXIS_MAE


def problem_of(cell: Cell, data: Dataset, gauges: Sequence[str]) -> Problem:
    """Return the training problem of a cell."""
    labels = getattr(data, cell.label)[data.is_train]
    levels = np.unique(getattr(data, cell.label)).astype(float)
    options: ProblemOptions = {
        "depth": cell.depth,
        "split": "axis" if cell.split_size == 1 else "hyperplane",
        "split_size": cell.split_size,
        "feature_names": tuple(gauges),
        "class_names": tuple(int(level) for level in levels),
    }
    if cell.objective == "mae":
        options["loss"] = ClassCosts(np.abs(levels[:, None] - levels))
    return Problem(data.features[data.is_train][:, columns_of(data, gauges)], labels, **options)


def effort_of(cell: Cell, restarts: int) -> tuple[Method, SearchOptions]:
    """Return method and options of a cell, where a hyperplane tree for mu2 gets `restarts`.

    Axis-aligned trees of depth 3 with fewest errors are proven within a second or two.
    """
    if cell.split_size == 1 and cell.depth == 3 and cell.objective == "errors":
        return "exact", SearchOptions()
    if cell.split_size == 1:
        return "search", SearchOptions(restarts=min(SHARE * restarts, EFFORT["axis"][0]))
    return "search", SearchOptions(restarts=SHARE * restarts if cell.label == "mu1" else restarts)


def run_cells(cells: Sequence[Cell], means: MeanStrains, recipe: Recipe, restarts: int) -> list[Line]:
    """Return what came of cells of one seed, label and set of gauges: they have the same readings.

    A line holds the cell, its error rates and MAE [percent loss of stiffness] on training and on unseen readings.
    """
    label, gauge_set, seed = cells[0].label, cells[0].gauge_set, cells[0].seed
    data = build_dataset(means, recipe, seed=seed)
    gauges = best_pair(data, label, seed) if gauge_set == "two" else data.gauges
    return [run_cell(cell, data, gauges, restarts) for cell in cells]


def run_cell(cell: Cell, data: Dataset, gauges: Sequence[str], restarts: int) -> Line:
    """Return what came of one cell."""
    problem = problem_of(cell, data, gauges)
    before = cpu_seconds()
    method, options = effort_of(cell, restarts)
    solution = solve(problem, method, seed=cell.seed, options=options)
    cpu = cpu_seconds() - before
    certificate = certify(problem, solution)
    assert solution.tree is not None
    figures: Line = {}
    for name, rows in (("train", data.is_train), ("test", ~data.is_train)):
        features, truth = data.features[rows][:, columns_of(data, gauges)], getattr(data, cell.label)[rows]
        deviation = np.abs(np.array(problem.class_names)[predict(solution.tree, features)] - truth)
        figures |= {f"{name}_error_rate": float((deviation > 0).mean()), f"{name}_mae": float(deviation.mean())}
    size = {"n_splits": certificate.n_splits, "gauges": list(certificate.sensors)}
    return {**asdict(cell), **figures, **size, "method": method, **options.given(), "cpu_seconds": round(cpu, 2)}


def columns_of(data: Dataset, gauges: Sequence[str]) -> list[int]:
    """Return the columns of some gauges."""
    return [data.gauges.index(gauge) for gauge in gauges]


def bayes_limits(means: MeanStrains, gauges: Sequence[str] | None = None) -> dict[str, BayesLimit]:
    """Return the Bayes limit of each label on some gauges, or all; it depends on mean strains and noise, no seed."""
    data = build_dataset(means, Recipe(), seed=0)
    strains = data.mean_features[:, columns_of(data, gauges or data.gauges)]
    levels = data.states_percent.astype(float)
    return {
        label: bayes_limit(strains, levels[:, k], data.noise_sd, np.random.default_rng(0))
        for k, label in enumerate(LABELS)
    }


def pair_limits(means: MeanStrains, lines: dict[Cell, Line]) -> dict[str, float]:
    """Return for each label the Bayes limit of the MAE with two gauges, the mean over the pairs that the trees read."""
    pairs = {(cell.label, cell.seed): tuple(line["gauges"]) for cell, line in lines.items() if cell.gauge_set == "two"}
    limits = {pair: bayes_limits(means, pair) for pair in set(pairs.values())}
    return {
        label: float(np.mean([limits[pair][label].mae for (of, _), pair in pairs.items() if of == label]))
        for label in LABELS
    }
