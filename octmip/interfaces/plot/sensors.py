"""What each sensor is worth: the optimum without it, and of the trees that read it."""

import math

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from octmip.interfaces.plot.names import drawn, plain
from octmip.interfaces.plot.style import DISTINCT, INK, QUIET, Picture, quiet_frame
from octmip.trees.near_sets import Role, SensorRoles

COLOURS = {Role.NEEDED: DISTINCT[1], Role.REPLACEABLE: DISTINCT[0], Role.USELESS: QUIET, Role.UNKNOWN: DISTINCT[5]}


def sensors_figure(found: SensorRoles) -> Figure:
    """Return two bars per sensor, both from the optimum: right, the price of losing it; left, of having to read it.

    The colour is the sensor's role; the shaded band is what counts as near-optimal.

    >>> problem = Problem([[0, 5], [1, 5], [2, 7]], ["a", "b", "b"], depth=1)
    >>> sensors_figure(sensor_roles(problem)).savefig("sensors.svg")
    """
    best = found.solution.objective
    figure = Picture(figsize=(6.4, 1.1 + 0.24 * len(found.roles)), layout="tight")
    axes = figure.add_subplot()
    lost = [role.without.objective - best for role in found.roles]
    read = [role.forced - best for role in found.roles]
    widest = max([1e-9, *lost, *(cost for cost in read if math.isfinite(cost))])
    axes.axvspan(best - found.limit, found.limit - best, color=INK, alpha=0.07, linewidth=0)
    for k, role in enumerate(found.roles):
        colour, left = COLOURS[role.role], -min(read[k], widest)
        axes.barh(k, lost[k], color=colour, height=0.62)
        axes.barh(k, left, color=colour, height=0.62, alpha=0.45)
        _note(axes, f"{lost[k]:.4g}", (lost[k], k), 3)
        _note(axes, f"{read[k]:.4g}" if math.isfinite(read[k]) else "no tree", (left, k), -3)
    axes.axvline(0, color=INK, linewidth=0.8)
    axes.set_xlim(-1.18 * widest, 1.18 * widest)
    names = [role.sensor for role in found.roles]
    axes.set_yticks(range(len(names)), [drawn(name, names) for name in names])
    for label in axes.get_yticklabels():
        plain(label)
    axes.invert_yaxis()
    axes.xaxis.set_major_formatter(lambda value, _: f"{abs(value):g}")
    axes.set_xlabel("above the optimum: when it must be read (left), without it (right)", color=INK)
    for kind in dict.fromkeys(role.role for role in found.roles):
        axes.barh(0, 0, color=COLOURS[kind], label=str(kind))
    above = 1.0 + 0.9 / len(found.roles)
    axes.legend(frameon=False, fontsize=8, loc="upper center", bbox_to_anchor=(0.5, above), ncols=4)
    quiet_frame(axes)
    return figure


def _note(axes: Axes, text: str, place: tuple[float, float], aside: float) -> None:
    """Write a figure beside the end of a bar."""
    align = "left" if aside > 0 else "right"
    axes.annotate(text, place, (aside, 0), textcoords="offset points", va="center", ha=align, fontsize=7, color=INK)
