"""The wing with its installed and candidate gauges, coloured by sensitivity, and those that the tree chose."""

from collections.abc import Sequence

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import LogNorm
from matplotlib.figure import Figure
from numpy.typing import NDArray

from benchmarks.uav.pictures import draw_planform
from femlib.wing import Wing
from octmip.interfaces.plot.style import INK, QUIET, quiet_frame

CHOSEN = "#d55e00"
MARKERS = {"installed": ("g", "s"), "candidate": ("c", "o")}  # first letter of the names, marker
NAME_HEIGHT, NAME_WIDTH = 0.16, 0.035  # [m] ahead of the spar, clear of the leading edge; along the span


def placement_figure(wing: Wing, sensitivity: NDArray[np.float64], chosen: Sequence[str]) -> Figure:
    """Return planform, damage regions and gauges.

    Parameters
    ----------
    wing
        with its gauges.
    sensitivity
        (n_gauges,) change of reading from no to 80 % loss in region 2 at 3 g [microstrain].
    chosen
        names of the gauges that the tree reads.
    """
    figure = Figure(figsize=(10, 4.0), layout="constrained")
    axes = figure.subplots()
    draw_planform(axes, wing)
    axes.set_aspect("equal")
    axes.set_yticks([])
    axes.set_xlabel("distance from the root [m]", color=INK, fontsize=9)
    quiet_frame(axes)
    usable = wing.gauges.is_usable
    scale = ScalarMappable(LogNorm(max(1.0, sensitivity[usable].min()), sensitivity[usable].max()), "viridis")
    for letter, marker in MARKERS.values():
        is_kind = np.array([name.startswith(letter) for name in wing.gauges.names])
        for mask, hollow in ((is_kind & usable, False), (is_kind & ~usable, True)):
            x, y = wing.gauges.position[mask, 1], -wing.gauges.position[mask, 0]
            colour = "none" if hollow else scale.to_rgba(np.clip(sensitivity[mask], *scale.get_clim()))
            axes.scatter(x, y, 34, c=colour, marker=marker, edgecolors=QUIET, linewidths=0.7, zorder=2)
    _mark_chosen(axes, wing, chosen)
    bar = figure.colorbar(scale, ax=axes, shrink=0.75, pad=0.01)
    bar.set_label("change at 80 % loss in region 2 [microstrain]", color=INK, fontsize=8)
    bar.ax.tick_params(labelsize=8)
    _legend(figure, axes)
    return figure


def _mark_chosen(axes: Axes, wing: Wing, chosen: Sequence[str]) -> None:
    """Ring the chosen gauges; their names stand upright in a row ahead of the wing, apart enough to be read."""
    places = wing.gauges.position[[wing.gauges.names.index(name) for name in chosen]]
    order = np.argsort(places[:, 1], kind="stable")
    at = places[order, 1].copy()
    for _ in range(200):  # push neighbours apart until all are
        gap = NAME_WIDTH - np.diff(at)
        if (gap <= 1e-6).all():
            break
        push = np.maximum(gap, 0.0) / 2
        at[:-1] -= push
        at[1:] += push
    for k, x in zip(order, at, strict=True):
        place = float(places[k, 1]), -float(places[k, 0])
        axes.scatter(*place, 120, facecolors="none", edgecolors=CHOSEN, linewidths=1.6, zorder=3)
        arrow = {"arrowstyle": "-", "color": CHOSEN, "lw": 0.6, "shrinkB": 5, "shrinkA": 1}
        axes.annotate(
            chosen[k],
            place,
            (float(x), NAME_HEIGHT),
            arrowprops=arrow,
            zorder=4,
            ha="center",
            va="bottom",
            fontsize=8,
            rotation=90,
            color=CHOSEN,
        )
    axes.set_ylim(top=NAME_HEIGHT + 0.09)


def _legend(figure: Figure, axes: Axes) -> None:
    grey = matplotlib.colors.to_rgba(QUIET)
    marks = [axes.scatter([], [], 34, color=grey, marker=marker) for _, marker in MARKERS.values()]
    marks.append(axes.scatter([], [], 34, facecolors="none", edgecolors=QUIET))
    marks.append(axes.scatter([], [], 120, facecolors="none", edgecolors=CHOSEN, linewidths=1.8))
    names = [*MARKERS, "inside a region: not usable", "read by the tree"]
    figure.legend(marks, names, loc="outside lower center", ncols=len(names), frameon=False, fontsize=8)
