"""The pictures of the study: trees, two-gauge partitions, the wing with its gauges, strain along the span."""

from collections.abc import Sequence

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.figure import Figure
from matplotlib.patches import Polygon

from femlib.dataset import MeanStrains
from femlib.wing import Wing

INK, QUIET, ACCENT, DAMAGE = "#222222", "#9aa3ad", "#c2410c", "#f2b8a0"


def wing_picture(wing: Wing, used: dict[str, Sequence[str]]) -> Figure:
    """Return the planform with damage regions and gauges, one panel a label; the gauges its tree uses stand out."""
    figure, axes = plt.subplots(len(used), 1, figsize=(9, 2.3 * len(used)), squeeze=False, layout="constrained")
    for axis, (title, gauges) in zip(axes[:, 0], used.items(), strict=True):
        _draw_planform(axis, wing)
        for name, position in zip(wing.gauges.names, wing.gauges.position, strict=True):
            is_used = name in gauges
            axis.plot(position[1], -position[0], "o", ms=9 if is_used else 4, color=ACCENT if is_used else QUIET)
            if is_used:
                axis.annotate(name, (position[1], -position[0]), (0, 8), textcoords="offset points", ha="center")
        axis.set_title(title, loc="left", fontsize=10)
        axis.set_aspect("equal")
        axis.set_yticks([])
        axis.spines[["top", "right", "left"]].set_visible(False)
    axes[-1, 0].set_xlabel("distance from the root [m]")
    return figure


def _draw_planform(axis: plt.Axes, wing: Wing) -> None:
    outline = wing.outline()
    axis.add_patch(Polygon(np.column_stack([outline[:, 1], -outline[:, 0]]), closed=True, fill=False, ec=INK, lw=1.2))
    for region in wing.regions:
        corners = wing.region_outline(region)
        patch = np.column_stack([corners[:, 1], -corners[:, 0]])
        axis.add_patch(Polygon(patch, closed=True, fc=DAMAGE, ec="none", zorder=0))
        axis.annotate(region.parameter, patch[:4].mean(axis=0), ha="center", va="center", fontsize=9, color=INK)
    axis.autoscale_view()


def strain_picture(means: MeanStrains, wing: Wing, published: MeanStrains | None) -> Figure:
    """Return strain at the undamaged state along the span, the two gauge rows, against the published table."""
    figure, axis = plt.subplots(figsize=(8, 4), layout="constrained")
    rows = {"row A": [f"g{k:02d}" for k in range(1, 17)], "row B": [f"g{k:02d}" for k in range(17, 25)]}
    for (row, names), marker in zip(rows.items(), "os", strict=True):
        for source, colour, table in (("femlib's wing", ACCENT, means), ("published", INK, published)):
            if table is None:
                continue
            eta = [wing.gauges.eta[wing.gauges.names.index(name)] for name in names]
            pristine = _pristine(table)
            strain = [pristine[table.gauges.index(name)] for name in names]
            filled = source != "published"
            axis.plot(
                eta, strain, marker, color=colour, mfc=colour if filled else "none", ms=6, label=f"{source}, {row}"
            )
    axis.set_xlabel("span fraction")
    axis.set_ylabel(f"compressive strain at {means.load_factor:g} g [microstrain]")
    axis.set_title("Strain of the undamaged wing along the span", loc="left", fontsize=10)
    axis.spines[["top", "right"]].set_visible(False)
    axis.legend(frameon=False, fontsize=8)
    return figure


def _pristine(means: MeanStrains) -> np.ndarray:
    row = int(np.flatnonzero((means.states_percent == 0).all(axis=1))[0])
    return means.strain_microstrain[row]
