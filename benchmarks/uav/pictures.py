"""The pictures of the study: trees, two-gauge partitions, the wing with its gauges, strain along the span."""

from collections.abc import Sequence

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray
from sklearn.datasets import load_iris

from femlib.dataset import MeanStrains
from femlib.wing import Wing
from femlib.wing.export.pictures import ACCENT, DAMAGE, INK, draw_planform
from octmip import Limits, Problem, certify, predict, solve
from octmip.interfaces.plot import partition_figure

NAME_HEIGHT = 0.16  # [m] ahead of the spar: clear of the leading edge
QUIET = "#9aa3ad"
FLOWER = (4.8, 1.75)  # petal length and width of a flower of no known species [cm]


def wing_picture(wing: Wing, used: dict[str, Sequence[str]]) -> Figure:
    """Return the planform with damage regions and gauges, one panel a label; the gauges its tree uses stand out."""
    figure, axes = plt.subplots(len(used), 1, figsize=(9, 2.3 * len(used)), squeeze=False, layout="constrained")
    for axis, (title, gauges) in zip(axes[:, 0], used.items(), strict=True):
        draw_planform(axis, wing, "top", DAMAGE)
        axis.autoscale_view()
        for name, position in zip(wing.gauges.names, wing.gauges.position, strict=True):
            is_used = name in gauges
            place = (position[1], -position[0])
            axis.plot(*place, "o", ms=8 if is_used else 4, color=ACCENT if is_used else QUIET)
            if is_used:  # neighbours stand closer than their names are wide, so the names stand upright, off the wing
                style = {"ha": "center", "va": "bottom", "fontsize": 6.5, "rotation": 90}
                arrow = {"arrowstyle": "-", "color": QUIET, "lw": 0.8, "shrinkB": 4}
                axis.annotate(name, place, (place[0], NAME_HEIGHT), arrowprops=arrow, **style)
        axis.set_title(title, loc="left", fontsize=10)
        axis.set_ylim(top=NAME_HEIGHT + 0.09)
        axis.set_aspect("equal")
        axis.set_yticks([])
        axis.spines[["top", "right", "left"]].set_visible(False)
    axes[-1, 0].set_xlabel("distance from the root [m]")
    return figure


def strain_picture(wing: Wing, simulated: MeanStrains, published: MeanStrains | None) -> Figure:
    """Return strain at the undamaged state along the span, the two gauge rows, against the published table if given."""
    figure, axis = plt.subplots(figsize=(8, 4), layout="constrained")
    rows = {"row A": [f"g{k:02d}" for k in range(1, 17)], "row B": [f"g{k:02d}" for k in range(17, 25)]}
    for (row, names), marker in zip(rows.items(), "os", strict=True):
        for source, colour, table in (("femlib's wing", ACCENT, simulated), ("published", INK, published)):
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
    axis.set_ylabel(f"compressive strain at {simulated.load_factor:g} g [microstrain]")
    axis.set_title("Strain of the undamaged wing along the span", loc="left", fontsize=10)
    axis.spines[["top", "right"]].set_visible(False)
    axis.legend(frameon=False, fontsize=8)
    return figure


def iris_picture(seed: int) -> Figure:
    """Return the paper's first example: the best lines in the plane of iris's petals, and a flower that they sort."""
    iris = load_iris()
    columns = [iris.feature_names.index(f"petal {size} (cm)") for size in ("length", "width")]
    names = tuple(iris.feature_names[column] for column in columns)
    species = [str(iris.target_names[code]) for code in iris.target]
    petals = iris.data[:, columns]
    problem = Problem(petals, species, depth=2, split="hyperplane", split_size=2, feature_names=names)
    solution = solve(problem, "exact", limits=Limits(seconds=10.0), seed=seed)
    certify(problem, solution)
    told = problem.samples.class_names[predict(solution.tree, np.array([FLOWER]))[0]]
    title = f"iris: {solution.objective:g} of {len(species)} wrong, bound {solution.bound:g}; the star is {told}"
    figure = partition_figure(problem, solution.tree, title=title)
    figure.axes[0].plot(*FLOWER, "*", ms=16, color="white", mec=INK)
    return figure


def _pristine(means: MeanStrains) -> NDArray[np.float64]:
    row = int(np.flatnonzero((means.states_percent == 0).all(axis=1))[0])
    strain: NDArray[np.float64] = means.strain_microstrain[row]
    return strain
