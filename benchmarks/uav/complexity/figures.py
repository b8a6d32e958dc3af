"""The study's two figures: MAE against depth, one line per split size, on training and on unseen readings."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from benchmarks.uav.bayes import BayesLimit
from benchmarks.uav.complexity.cells import DEPTHS, LABELS, SPLIT_SIZES, Cell, Objective
from benchmarks.uav.complexity.tables import SIZE_NAMES, Lines, values
from octmip.interfaces.plot.style import DISTINCT, INK, quiet_frame

MARKERS = "osd^"


def complexity_figure(lines: Lines, limits: dict[str, BayesLimit], objective: Objective, rows: str) -> Figure:
    """Return MAE against depth on the "train" or "test" rows, one panel a label; bars show the range over the seeds.

    What lies in the shade is below the Bayes limit: on training readings that is overfitted noise.
    """
    figure = Figure(figsize=(8.4, 3.8), layout="constrained")
    seeds = max(cell.seed for cell in lines) + 1
    for axes, label in zip(figure.subplots(1, 2), LABELS, strict=True):
        for k, size in enumerate(SPLIT_SIZES):
            _line(axes, lines, Cell(label, "all", 0, size, objective, 0), f"{rows}_mae", k)
        limit = limits[label].mae
        axes.axhspan(0, limit, color=INK, alpha=0.07, linewidth=0)
        axes.axhline(limit, color=INK, linestyle="--", linewidth=1)
        axes.set_ylim(bottom=-0.03 * axes.get_ylim()[1])  # so that marks at 0 are seen whole
        axes.set_xticks(DEPTHS)
        axes.set_xlabel("depth", color=INK)
        axes.set_title(f"{label}; Bayes limit {limit:.2f} (dashed)", fontsize=9, color=INK, loc="left")
        quiet_frame(axes)
    readings = {"train": "training", "test": "unseen"}[rows]
    figure.axes[0].set_ylabel(f"MAE, {readings} readings [% stiffness]", color=INK)
    trained = {"errors": "misclassification", "mae": "mean absolute error"}[objective]
    many = f"mean and range of {seeds} seeds" if seeds > 1 else "one seed"
    marks, names = figure.axes[1].get_legend_handles_labels()
    figure.legend(marks, names, loc="outside lower center", ncols=len(names), frameon=False, fontsize=8)
    figure.suptitle(f"Trees trained for {trained}; {many}", fontsize=10, color=INK)
    return figure


def _line(axes: Axes, lines: Lines, cell: Cell, name: str, k: int) -> None:
    """Draw one split size; `k` is its place among them, by which the bars are set apart."""
    found = {depth: values(lines, _at(cell, depth), name) for depth in DEPTHS}
    depths = [depth for depth in DEPTHS if len(found[depth])]
    if not depths:
        return
    means = np.array([found[depth].mean() for depth in depths])
    low = means - [found[depth].min() for depth in depths]
    high = [found[depth].max() for depth in depths] - means
    places = np.array(depths) + 0.06 * (k - 1.5)
    label = "axis-aligned" if cell.split_size == 1 else f"{SIZE_NAMES[cell.split_size]} features per split"
    axes.errorbar(
        places, means, (low, high), color=DISTINCT[k], marker=MARKERS[k], markersize=4, linewidth=1.2, label=label
    )


def _at(cell: Cell, depth: int) -> Cell:
    return Cell(cell.label, cell.gauge_set, depth, cell.split_size, cell.objective, cell.seed)
