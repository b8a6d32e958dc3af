"""Placement: 67 candidate gauges against the 20 installed ones and against other ways to choose as many gauges.

mu2 (the hard label), at most four features per split, trained for the MAE by the cost matrix |mu_i - mu_k|. The tree
over all candidates gives the number of gauges that it reads; every other way of choosing gets as many. At each depth
the trees of every set of gauges are searched with the same effort. At depths 4 and 5 only the paper's comparison is
made, candidates against installed, and the one without the candidates beside a damage region.
"""

from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from benchmarks.cpu import cpu_seconds
from benchmarks.tables import Line
from benchmarks.uav.bayes import bayes_limit
from benchmarks.uav.kept import keep, kept_lines, key_of
from benchmarks.uav.report import write_figure
from benchmarks.uav.sensing.picture import placement_figure
from benchmarks.uav.sensing.readings import (
    candidate_wing,
    clear_of_regions,
    installed,
    mean_absolute_error,
    mean_strains,
    problem_of,
    readings,
)
from femlib.dataset import Dataset, MeanStrains
from octmip import Problem, certify
from octmip.interfaces.report.markdown import markdown_table
from octmip.sensing import by_chance, by_information, by_reading, by_tree, place_sensors, placement_on
from octmip.trees.methods.options import SearchOptions

LABEL, SPLIT_SIZE = "mu2", 4
DEPTHS = (3, 4, 5)
COMPARED_DEPTH = 3  # at which all ways of choosing are compared
RANDOM_CHOICES = 1  # per seed
DEEPER_SEEDS = 1  # trees of depth 4 and 5 take minutes
EFFORT = SearchOptions(restarts=6)
GREEDY_ROWS = 400
# The paper's train MAE at depth 3, four features per split: the installed gauges, all candidates.
PAPER = {"installed": 11.64, "candidates": 9.89}
STARTED = "candidates, from D-optimal"  # the search over all candidates begins at the D-optimal choice's tree
CLEAR = "candidates, 40 mm clear"  # of every damage region
CHOICES = ("candidates", "installed", CLEAR, "D-optimal", STARTED, "random", "greedy", "highest strain")


@dataclass(frozen=True, slots=True)
class Cell:
    """One tree: how its gauges are chosen, its depth, the seed of readings and search, which of several choices."""

    choice: str
    depth: int
    seed: int
    number: int = 0


def report(source: str, folder: Path, seeds: int, is_smoke: bool) -> str:
    """Run what is not kept in lines.jsonl, write the picture and return the table."""
    if source != "wing":
        return "The published table has 24 gauges and no candidates: see the wing.\n"
    lines: dict[Cell, Line] = {}
    kept = None if is_smoke else folder / "lines.jsonl"
    for depth in DEPTHS[:1] if is_smoke else DEPTHS:
        for seed in range(1 if is_smoke else seeds if depth == COMPARED_DEPTH else min(seeds, DEEPER_SEEDS)):
            lines |= run_seed(seed, depth, is_smoke, kept)
    write_figure(folder, "placement", picture(lines))
    return f"## Placement\n\n{markdown_table(table_rows(lines))}\n"


def run_seed(seed: int, depth: int, is_smoke: bool, kept: Path | None) -> dict[Cell, Line]:
    """Return the lines of one seed and depth: first the tree over all candidates, then those of as many gauges."""
    data = readings("wing", seed, is_smoke)
    known = kept_lines(kept)
    lines: dict[Cell, Line] = {}
    n_gauges = 0
    for cell in cells(seed, depth):
        key = key_of(mean_strains("wing"), asdict(cell), EFFORT.given(), GREEDY_ROWS, is_smoke)
        if key not in known:
            known[key] = run_cell(cell, data, n_gauges, is_smoke)
            keep(kept, key, known[key])
        lines[cell] = known[key]
        if cell.choice == "candidates":
            n_gauges = len(lines[cell]["gauges"])
    return lines


def cells(seed: int, depth: int) -> list[Cell]:
    """Return the cells of one seed and depth, the tree over all candidates first."""
    choices = CHOICES if depth == COMPARED_DEPTH else CHOICES[:3]
    return [
        Cell(choice, depth, seed, number)
        for choice in choices
        for number in range(RANDOM_CHOICES if choice == "random" else 1)
    ]


def run_cell(cell: Cell, data: Dataset, n_gauges: int, is_smoke: bool) -> Line:
    """Return errors (MAE in training, on unseen readings, least possible), gauges and effort of one cell."""
    problem = problem_of(data, LABEL, cell.depth, data.gauges, SPLIT_SIZE, for_mae=True)
    effort = SearchOptions(restarts=1, perturbations=0) if is_smoke else EFFORT
    n_gauges = min(n_gauges, 3) if is_smoke else n_gauges
    before = cpu_seconds()
    is_started = cell.choice == STARTED
    chosen_gauges = choose(replace(cell, choice="D-optimal") if is_started else cell, problem, data, n_gauges)
    chosen = cpu_seconds() - before
    if is_started:
        within = replace(problem, sensor_budget=float(n_gauges))
        placed = place_sensors(within, starts=[chosen_gauges], method="search", seed=cell.seed, options=effort)
    else:
        placed = placement_on(problem, chosen_gauges, method="search", seed=cell.seed, options=effort)
    tree = placed.solution.tree
    assert tree is not None
    used = placed.problem.sensors_used(tree)
    columns = [data.gauges.index(gauge) for gauge in placed.problem.sensors]
    limit = bayes_limit(
        data.mean_features[:, columns],
        data.states_percent[:, 1].astype(float),
        data.noise_sd,
        np.random.default_rng(0),
        100 if is_smoke else 2000,
    )
    return {
        "choice": cell.choice,
        "depth": cell.depth,
        "seed": cell.seed,
        "number": cell.number,
        "train_mae": mean_absolute_error(data, LABEL, placed.problem.sensors, tree, data.is_train),
        "test_mae": mean_absolute_error(data, LABEL, placed.problem.sensors, tree, ~data.is_train),
        "bayes_mae": limit.mae,
        "allowed": list(placed.problem.sensors),
        "gauges": list(used),
        "n_splits": certify(placed.problem, placed.solution).n_splits,
        "choosing_cpu_s": round(chosen, 2),
        "cpu_s": round(cpu_seconds() - before - chosen, 2),
    }


def choose(cell: Cell, problem: Problem, data: Dataset, n_gauges: int) -> tuple[str, ...]:
    """Return the gauges of a cell: the installed ones, or `n_gauges` of all candidates in its way."""
    ways: dict[str, Callable[[], tuple[str, ...]]] = {
        "candidates": lambda: data.gauges,
        "installed": lambda: installed(data),
        CLEAR: lambda: clear_of_regions(data),
        "highest strain": lambda: by_reading(problem, n_gauges),
        "D-optimal": lambda: by_information(problem, n_gauges, sensitivities(data)).sensors,
        "greedy": lambda: by_tree(problem, n_gauges, rows=GREEDY_ROWS, seed=cell.seed),
        "random": lambda: by_chance(problem, n_gauges, np.random.default_rng([cell.seed, cell.number])),
    }
    return ways[cell.choice]()


def sensitivities(data: Dataset) -> NDArray[np.float64]:
    """Return (25, n_gauges, 2): differences of the mean readings along mu1 and mu2 in each state [microstrain]."""
    grid = data.mean_features.reshape(5, 5, -1)
    along = [np.asarray(np.gradient(grid, axis=axis)).reshape(25, -1) for axis in (0, 1)]
    return np.stack(along, axis=2)


def table_rows(lines: dict[Cell, Line]) -> list[dict[str, object]]:
    """Return a row for each depth and way of choosing: means over seeds."""
    rows: list[dict[str, object]] = []
    for depth in sorted({cell.depth for cell in lines}):
        for choice in CHOICES:
            found = [line for cell, line in lines.items() if (cell.choice, cell.depth) == (choice, depth)]
            if found:
                rows.append({"depth": depth, "gauges from": choice, **_means(found), "paper": _paper(choice, depth)})
    return rows


def _means(found: Sequence[Line]) -> dict[str, object]:
    test = [line["test_mae"] for line in found]
    return {
        "may read": f"{np.mean([len(line['allowed']) for line in found]):.1f}",
        "reads": f"{np.mean([len(line['gauges']) for line in found]):.1f}",
        "train MAE": f"{np.mean([line['train_mae'] for line in found]):.2f}",
        "test MAE": f"{np.mean(test):.2f} ({min(test):.2f} to {max(test):.2f})",
        "Bayes limit": f"{np.mean([line['bayes_mae'] for line in found]):.2f}",
        "trees": len(found),
        "CPU s per tree": f"{np.mean([line['cpu_s'] for line in found]):.1f}",
        "CPU s to choose": f"{np.mean([line['choosing_cpu_s'] for line in found]):.1f}",
    }


def _paper(choice: str, depth: int) -> str:
    return f"{PAPER[choice]}" if depth == COMPARED_DEPTH and choice in PAPER else ""


def picture(lines: dict[Cell, Line]) -> Figure:
    """Return the wing with the gauges that the depth-3 tree of seed 0 chose."""
    chosen = lines[Cell("candidates", COMPARED_DEPTH, 0)]["gauges"]
    means: MeanStrains = mean_strains("wing")
    states = means.states_percent.tolist()
    change = means.strain_microstrain[states.index([0, 80])] - means.strain_microstrain[states.index([0, 0])]
    return placement_figure(candidate_wing(), np.abs(change), chosen)
