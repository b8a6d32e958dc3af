"""Plain error and worst case by the width of the band: the ordinary tree beside the one that survives reading errors.

`python -m benchmarks.worst_case.widths`: published strains, damage mu1, depth 2: table and picture of docs/sensing.md.
"""

from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from benchmarks.data import published
from benchmarks.main_program import run_main
from octmip import Problem, solve
from octmip.interfaces.report.markdown import markdown_table
from octmip.trees.worst_case import solve as solve_worst_case
from octmip.trees.worst_case import worst_case

LABEL = "mu1"
DEPTH = 2
NOISE_SD = np.sqrt(1000) / 3
"""Of one reading, in the units of the features [microstrain at 1 g]."""
WIDTHS = (0.0, 0.5, 1.0, 1.5, 2.0, 2.5, 3.0)
"""Half widths of the band, in standard deviations of the noise."""
PICTURE = Path(__file__).parents[2] / "docs" / "pictures" / "worst_case_widths.svg"


def rows() -> list[dict[str, float]]:
    """Return a line for each width: errors of 1750 training samples, and whether the least worst case is proven."""
    table = published(LABEL, 0)
    problem = Problem(table.features, table.labels, depth=DEPTH)
    ordinary = solve(problem, "exact").tree
    assert ordinary is not None
    found: list[dict[str, float]] = []
    for width in WIDTHS:
        given = worst_case(problem, ordinary, width * NOISE_SD)
        own = solve_worst_case(problem, width * NOISE_SD, incumbent=ordinary)
        found.append(
            {
                "half width, sd": width,
                "ordinary, plain": given.plain,
                "ordinary, worst": given.worst,
                "survives, plain": own.figures.plain,
                "survives, worst": own.figures.worst,
                "proven": own.solution.is_optimal,
            }
        )
    return found


def figure(lines: list[dict[str, float]]) -> Figure:
    """Return the picture of the table."""
    drawing = Figure(figsize=(5.6, 3.2), layout="tight")
    axes = drawing.add_subplot()
    widths = [line["half width, sd"] for line in lines]
    for tree, colour in (("ordinary", "#9a5b2f"), ("survives", "#2f6f9a")):
        label = {"ordinary": "ordinary tree", "survives": "tree that survives reading errors"}[tree]
        for kind, style in (("worst", "-"), ("plain", "--")):
            numbers = [line[f"{tree}, {kind}"] for line in lines]
            words = {"worst": "worst case", "plain": "no reading errors"}[kind]
            axes.plot(widths, numbers, style, color=colour, marker="o", markersize=3, label=f"{label}, {words}")
    axes.set_xlabel("half width of the band [standard deviations of the noise]")
    axes.set_ylabel("errors of 1750")
    axes.set_ylim(bottom=0)
    axes.legend(frameon=False, fontsize=8)
    return drawing


def main() -> None:
    """Print the table and draw it."""
    lines = rows()
    print(markdown_table(lines))
    figure(lines).savefig(PICTURE, metadata={"Date": None})


if __name__ == "__main__":
    run_main(main)
