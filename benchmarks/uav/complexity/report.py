"""The complexity study: its tables, and the two figures of each objective as SVG and PNG; the paper's figures."""

from collections.abc import Sequence
from pathlib import Path

from benchmarks.uav.bayes import BayesLimit
from benchmarks.uav.complexity.cells import (
    LABELS,
    OBJECTIVES,
    Cell,
    Objective,
    bayes_limits,
    pair_limits,
    paper_cells,
    study_cells,
)
from benchmarks.uav.complexity.figures import complexity_figure
from benchmarks.uav.complexity.lines import run
from benchmarks.uav.complexity.tables import Lines, complexity_table, overfitting, paper_table
from benchmarks.uav.report import write_figure
from benchmarks.uav.study import strains_of
from femlib.dataset import MeanStrains, Recipe
from octmip.input.files import write_bytes

RESTARTS = 4
"""Of hyperplanes for mu2; others have five times as many."""


def report(source: str, folder: Path, seeds: int, is_smoke: bool) -> str:
    """Return depth against features per split, and draw it."""
    means = strains_of(source)
    lines = _run(study_cells(range(1 if is_smoke else seeds)), means, folder, is_smoke)
    write_complexity(folder, lines, bayes_limits(means), OBJECTIVES)
    return (folder / "complexity.md").read_text()


def paper_report(source: str, folder: Path, seeds: int, is_smoke: bool) -> str:
    """Return the paper's own figures beside ours."""
    means = strains_of(source)
    lines = _run(paper_cells(range(1 if is_smoke else seeds)), means, folder, is_smoke)
    return f"# The paper's figures\n\n{paper_table(lines, bayes_limits(means), pair_limits(means, lines))}\n"


def _run(cells: Sequence[Cell], means: MeanStrains, folder: Path, is_smoke: bool) -> Lines:
    if is_smoke:
        return run(cells, means, 1, 1, recipe=Recipe(samples_per_state=6))
    return run(cells, means, RESTARTS, 1, folder / "lines.jsonl")


def write_complexity(
    folder: Path, lines: Lines, limits: dict[str, BayesLimit], objectives: Sequence[Objective]
) -> None:
    """Write the tables and the figures into a folder that exists."""
    n_seeds = len({cell.seed for cell in lines})
    shown = ", ".join(f"{label} {limits[label].mae:.2f}" for label in LABELS)
    seeds = f"means of {n_seeds} seeds" if n_seeds > 1 else "one seed"
    text = (
        "# Complexity: depth and features per split\n\n"
        f"Train / test MAE in percent stiffness by local search, {seeds}. "
        f"Bayes limit: {shown}. A star marks a training MAE below it: overfitted noise.\n"
    )
    for objective in objectives:
        text += f"\n## Trained for {objective}\n\n{complexity_table(lines, objective, limits)}\n\n"
        text += "".join(f"* {sentence}\n" for sentence in overfitting(lines, objective, limits))
        for rows in ("train", "test"):
            figure = complexity_figure(lines, limits, objective, rows)
            write_figure(folder, f"complexity_{objective}_{rows}", figure)
    write_bytes(folder / "complexity.md", text.encode())
