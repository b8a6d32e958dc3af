"""The rates of the standard problems: error against the number of elements, a panel for each problem."""

from collections.abc import Sequence
from pathlib import Path

from benchmarks.tables import Line

COLUMNS = 4
LEAST = 1e-4
"""Errors below are drawn here: the published answers have three or four digits."""
LOOKS = {
    "femlib quadrilateral": ("#1b4f9c", "-", "s"),
    "femlib triangle": ("#1b4f9c", "--", "^"),
    "pyfe3d Quad4": ("#c65b1f", "-", "s"),
    "pyfe3d Tria3DSG": ("#c65b1f", "--", "^"),
    "CalculiX S4": ("#5a5a5a", "--", "s"),
    "CalculiX S8R": ("#5a5a5a", "-", "o"),
}


def draw(lines: Sequence[Line], path: Path) -> None:
    """Draw lines with problem, solver, elements and ratio into a file."""
    import matplotlib as mpl
    from matplotlib.figure import Figure

    names = list(dict.fromkeys(line["problem"] for line in lines))
    n_rows = -(-len(names) // COLUMNS)
    with mpl.rc_context(
        {
            "svg.hashsalt": "shells",
            "svg.fonttype": "none",
            "font.size": 8,
            "axes.spines.top": False,
            "axes.spines.right": False,
        }
    ):
        figure = Figure(figsize=(11.0, 2.1 * n_rows + 0.5), layout="constrained")
        axes = figure.subplots(n_rows, COLUMNS, sharex=True, sharey=True, squeeze=False).ravel()
        for axis, name in zip(axes, names, strict=False):
            for solver, (color, style, marker) in LOOKS.items():
                own = [line for line in lines if (line["problem"], line["solver"]) == (name, solver)]
                errors = [min(max(abs(line["ratio"] - 1.0), LEAST), 1.0) for line in own]
                places = [line["elements"] for line in own]
                axis.loglog(places, errors, style, color=color, marker=marker, ms=3, lw=1, label=solver)
            axis.axhline(0.02, color="#b0b0b0", lw=0.6, zorder=0)
            axis.set_title(name, fontsize=8, loc="left")
            axis.set_ylim(0.8 * LEAST, 1.3)
            axis.minorticks_off()
        for axis in axes[len(names) :]:
            axis.axis("off")
        figure.supxlabel("quadrilaterals (twice as many triangles, a quarter as many S8R)", fontsize=8)
        figure.supylabel("error of the displacement (grey line: 2 %)", fontsize=8)
        handles, labels = axes[0].get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside upper center", ncols=6, frameon=False)
        figure.savefig(path, metadata={"Date": None} if path.suffix == ".svg" else {})
