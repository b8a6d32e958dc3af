"""The study in tables: means over seeds beside the Bayes limit, the paper's figures, two objectives compared."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from benchmarks.tables import Line, markdown
from benchmarks.uav.bayes import BayesLimit
from benchmarks.uav.complexity.cells import DEPTHS, LABELS, OBJECTIVES, SPLIT_SIZES, Cell, Objective

Lines = dict[Cell, Line]
SIZE_NAMES = {1: "1", 2: "2", 4: "4", None: "unlimited"}
PAPER_AXIS_MAE = 16.9
"""The paper's mu2 at depth 3, axis-aligned, all gauges: what its other mu2 figures are compared with as ratios."""


@dataclass(frozen=True, slots=True)
class PaperFigure:
    """A figure of the paper: train and test MAE [percent] of one kind of tree, test None where it gives none."""

    label: str
    gauge_set: str
    depth: int
    split_size: int | None
    train: float
    test: float | None = None


PAPER = (
    PaperFigure("mu1", "two", 3, 1, 0.65, 0.88),
    PaperFigure("mu1", "two", 3, 2, 0.22, 0.40),
    PaperFigure("mu1", "all", 4, 2, 0.0),
    PaperFigure("mu2", "two", 3, 1, 19.44, 20.7),
    PaperFigure("mu2", "all", 3, 1, PAPER_AXIS_MAE),
    PaperFigure("mu2", "all", 3, 4, 11.64),
    PaperFigure("mu2", "all", 6, None, 7.76),
)


def values(lines: Lines, cell: Cell, name: str) -> NDArray[np.float64]:
    """Return a figure of the cell for every seed that was run, seeds ascending."""
    same = [other for other in lines if replace(other, seed=cell.seed) == cell]
    return np.array([lines[other][name] for other in sorted(same, key=lambda other: other.seed)])


def complexity_table(lines: Lines, objective: Objective, limits: dict[str, BayesLimit]) -> str:
    """Return the study's grid: one row per depth, one column per split size, train / test MAE; a star: overfitting."""
    parts = []
    for label in LABELS:
        limit = limits[label].mae
        head = [f"{label}: depth", *(f"{SIZE_NAMES[size]} features per split" for size in SPLIT_SIZES), "Bayes limit"]
        rows = []
        for depth in DEPTHS:
            cells = [Cell(label, "all", depth, size, objective, 0) for size in SPLIT_SIZES]
            rows.append([str(depth), *(_train_and_test(lines, cell, limit) for cell in cells), f"{limit:.2f}"])
        parts.append(markdown(head, rows))
    return "\n\n".join(parts)


def overfitting(lines: Lines, objective: Objective, limits: dict[str, BayesLimit]) -> list[str]:
    """Return one sentence a label: from where on the training MAE is below the Bayes limit, and what tests best."""
    sentences = []
    for label in LABELS:
        limit = limits[label].mae
        cells = [Cell(label, "all", depth, size, objective, 0) for size in SPLIT_SIZES for depth in DEPTHS]
        mean = {cell: (_mean(lines, cell, "train_mae"), _mean(lines, cell, "test_mae")) for cell in cells}
        firsts = []
        for size in SPLIT_SIZES:
            below = [cell.depth for cell in cells if cell.split_size == size and mean[cell][0] < limit]
            firsts.append(f"{SIZE_NAMES[size]}: " + (f"from depth {min(below)}" if below else "nowhere"))
        best = min((cell for cell in cells if not np.isnan(mean[cell][1])), key=lambda cell: mean[cell][1])
        sentences.append(
            f"{label}: training MAE below the Bayes limit of {limit:.2f}, by features per split: {', '.join(firsts)}; "
            f"the best on unseen readings is depth {best.depth} with {SIZE_NAMES[best.split_size]}: "
            f"{mean[best][0]:.2f} in training, {mean[best][1]:.2f} unseen."
        )
    return sentences


def _mean(lines: Lines, cell: Cell, name: str) -> float:
    found = values(lines, cell, name)
    return float(found.mean()) if len(found) else np.nan


def _train_and_test(lines: Lines, cell: Cell, limit: float) -> str:
    train, test = values(lines, cell, "train_mae"), values(lines, cell, "test_mae")
    if not len(train):
        return "-"
    star = "*" if train.mean() < limit else ""
    return f"{train.mean():.2f}{star} / {test.mean():.2f}"


def paper_table(lines: Lines, limits: dict[str, BayesLimit], pair_limits: dict[str, float]) -> str:
    """Return the paper's figures beside ours: means and standard deviations over the seeds, and what is met.

    `limits` are on all gauges, `pair_limits` on two.
    """
    head = ["tree", "paper", "for errors: train", "test", "for MAE: train", "test", "seeds", "Bayes limit", "met"]
    rows = []
    for figure in PAPER:
        cells = [_cell(figure, objective) for objective in OBJECTIVES]
        shown = [_mean_and_deviation(values(lines, c, name)) for c in cells for name in ("train_mae", "test_mae")]
        paper = f"{figure.train:g}" + ("" if figure.test is None else f" / {figure.test:g}")
        limit = limits[figure.label].mae if figure.gauge_set == "all" else pair_limits[figure.label]
        n_seeds = str(len(values(lines, cells[0], "train_mae")))
        rows.append([_name(figure), paper, *shown, n_seeds, f"{limit:.2f}", _verdict(lines, figure)])
    return markdown(head, rows)


def _cell(figure: PaperFigure, objective: Objective) -> Cell:
    return Cell(figure.label, figure.gauge_set, figure.depth, figure.split_size, objective, 0)


def _name(figure: PaperFigure) -> str:
    gauges = {"two": "two gauges", "all": "20 gauges"}[figure.gauge_set]
    size = {1: "axis-aligned", None: "unlimited features per split"}.get(figure.split_size)
    return f"{figure.label}, {gauges}, depth {figure.depth}, {size or f'{figure.split_size} features per split'}"


def _verdict(lines: Lines, figure: PaperFigure) -> str:
    """Return by which of the two objectives a paper's figure is met, as it stands or as a ratio to the axis figure."""
    met = []
    for objective in OBJECTIVES:
        train = values(lines, _cell(figure, objective), "train_mae")
        axis = values(lines, Cell("mu2", "all", 3, 1, objective, 0), "train_mae")
        if not len(train):
            continue
        if train.mean() <= figure.train:
            met.append(f"{objective}: yes")
        elif (figure.label, figure.gauge_set) == ("mu2", "all") and len(axis) and figure.train != PAPER_AXIS_MAE:
            ratio, wanted = train.mean() / axis.mean(), figure.train / PAPER_AXIS_MAE
            met.append(f"{objective}: ratio {ratio:.2f}, {'yes' if ratio <= wanted else 'no'} (paper {wanted:.2f})")
        else:
            met.append(f"{objective}: no")
    return "; ".join(met)


def _mean_and_deviation(found: NDArray[np.float64]) -> str:
    if not len(found):
        return "-"
    spread = f" ± {found.std(ddof=1):.2f}" if len(found) > 1 else ""
    return f"{found.mean():.2f}{spread}"
