"""Colours and frames that all figures share."""

import io
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure

from octmip.errors import ProblemError
from octmip.trees.nodes.tree import Node, ValueLeaf, features_used, leaves
from octmip.trees.question.problem import Problem

DOTS_PER_INCH = 96
"""Of a picture in a notebook."""
INK, QUIET, PAPER = "#1f2933", "#7b8794", "#ffffff"


@dataclass(frozen=True, slots=True)
class Ground:
    """Colours of text, of lines, of the ground, of what is lit; and how far class colours are moved to white."""

    ink: str
    quiet: str
    paper: str
    accent: str
    whiter: float


LIGHT = Ground(INK, QUIET, PAPER, "#1c5cab", 0.0)
DARK = Ground("#e6e9ed", "#8b96a1", "#14171b", "#82b4f5", 0.3)
# Okabe & Ito (2008), yellow last: distinct for all common kinds of colour blindness.
DISTINCT = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#56b4e9", "#e69f00", "#999999", "#f0e442")


class Picture(Figure):
    """A figure that a notebook shows, without pyplot."""

    def _repr_png_(self) -> bytes:
        buffer = io.BytesIO()
        self.savefig(buffer, format="png", dpi=DOTS_PER_INCH)
        return buffer.getvalue()


def class_colours(class_names: Sequence[Any]) -> list[tuple[float, float, float]]:
    """Return one colour for each class: a scale in order when all are numbers, else distinct ones."""
    k = len(class_names)
    is_ordered = k > 2 and all(isinstance(name, int | float) and not isinstance(name, bool) for name in class_names)
    if is_ordered or k > len(DISTINCT):
        rank = np.argsort(np.argsort(class_names)) if is_ordered else np.arange(k)
        scale = matplotlib.colormaps["viridis"]
        return [to_rgb(scale(0.02 + 0.86 * r / (k - 1))) for r in rank.tolist()]
    return [to_rgb(colour) for colour in DISTINCT[:k]]


def quiet_frame(axes: Axes) -> None:
    """Draw frame and ticks thin and grey."""
    axes.tick_params(colors=QUIET, labelsize=8, labelcolor=INK)
    for side in axes.spines.values():
        side.set_color(QUIET)
        side.set_linewidth(0.7)


def check_names(problem: Problem, tree: Node) -> None:
    """Refuse a tree of another problem.

    Raises
    ------
    ProblemError
        it reads a feature or predicts a class that the problem lacks.
    """
    samples = problem.samples
    highest = max((*features_used(tree), -1))
    label = max(leaf.label for leaf in leaves(tree))
    is_number = problem.loss.predicts == "number" and all(isinstance(leaf, ValueLeaf) for leaf in leaves(tree))
    if highest >= samples.n_features or (label >= samples.n_classes and not is_number):
        raise ProblemError(
            f"the tree reads feature {highest} and predicts class {label} but the problem has "
            f"{samples.n_features} features and {samples.n_classes} classes; draw it with the problem "
            "that it was found for"
        )
