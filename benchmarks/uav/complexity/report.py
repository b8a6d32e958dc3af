"""Writes the complexity study: complexity.md, and the two figures of each objective as SVG and PNG."""

from collections.abc import Sequence
from pathlib import Path

from benchmarks.uav.bayes import BayesLimit
from benchmarks.uav.complexity.cells import LABELS, Objective
from benchmarks.uav.complexity.figures import complexity_figure
from benchmarks.uav.complexity.tables import Lines, complexity_table, overfitting
from benchmarks.uav.report import write_figure
from octmip.formats.files import write_bytes


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
