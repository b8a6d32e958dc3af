"""The drawing of a tree as a figure: boxes, lines and bars of `octmip.interfaces.report.tree.drawing`."""

from dataclasses import replace
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure
from matplotlib.patches import FancyBboxPatch, PathPatch, Rectangle
from matplotlib.path import Path
from numpy.typing import ArrayLike, NDArray

from octmip.errors import ProblemError
from octmip.formats.columns import Columns
from octmip.interfaces.plot.names import in_font, plain
from octmip.interfaces.plot.style import DARK, LIGHT, Ground, Picture, check_names, class_colours
from octmip.interfaces.report.tree.drawing import Answer, Box, draw_tree
from octmip.interfaces.report.tree.letters import text_width
from octmip.interfaces.report.tree.seen import Seen
from octmip.interfaces.report.tree.words import Wording
from octmip.trees.answer.certificate import leaf_counts
from octmip.trees.nodes.tree import Node, leaf_index
from octmip.trees.question.problem import Problem

PIXELS_PER_INCH = 96
LETTERS = 12.5
"""Size of the text [px]: the letters of DejaVu Sans are broader than those that the boxes were made for, at 14 px."""
WIDEST = 200.0
"""Width of a figure [inch]: PNG files and their memory end soon after, so that wider trees are drawn smaller."""
TITLE = 30
"""Height that a title takes [px]."""
TINT = 0.15
"""Share of the class colour in the ground of a leaf."""
TITLE_LETTERS = 1.15
"""Size of a title's letters over that of the other text."""
Colour = tuple[float, float, float]


def tree_figure(
    problem: Problem,
    tree: Node,
    title: str | None = None,
    columns: Columns | None = None,
    *,
    histograms: bool = False,
    sample: ArrayLike | None = None,
    dark: bool = False,
) -> Figure:
    """Return a drawing of a tree: its splits, yes on the left, and its leaves with answer, samples and a bar.

    Parameters
    ----------
    problem, tree
        the samples, and a tree for them.
    title
        above the tree.
    columns
        those that the features were made from, in whose words the splits are then written.
    histograms
        whether each split shows the values of the samples that come to it, and its threshold.
    sample
        (n_features,) or (1, n_features) one sample, whose way through the tree is marked.
    dark
        light lines on a dark ground.

    Raises
    ------
    ProblemError
        the tree reads a feature or predicts a class that the problem lacks, or `sample` is not one sample.

    Examples
    --------
    >>> problem = Problem([[0], [1], [2]], ["a", "b", "b"], depth=1)
    >>> tree_figure(problem, solve(problem).tree, "the best tree").savefig("tree.svg")
    """
    check_names(problem, tree)
    way = None if sample is None else _way(problem, tree, np.asarray(sample, dtype=np.float64))
    wording = Wording(problem.samples.feature_names, problem.samples.class_names, columns)
    seen = Seen.of(problem, tree, histograms)
    return counted_tree_figure(tree, wording, leaf_counts(problem, tree), title, seen=seen, way=way, dark=dark)


def _way(problem: Problem, tree: Node, sample: NDArray[np.float64]) -> int:
    if sample.shape not in ((problem.samples.n_features,), (1, problem.samples.n_features)):
        raise ProblemError(
            f"sample has shape {sample.shape}; expected one row of {problem.samples.n_features} features, as "
            "features[0]"
        )
    return int(leaf_index(tree, sample.reshape(1, -1))[0])


def counted_tree_figure(
    tree: Node,
    wording: Wording,
    counts: NDArray[np.int64],
    title: str | None = None,
    *,
    answer: Answer | None = None,
    seen: Seen | None = None,
    way: int | None = None,
    dark: bool = False,
) -> Figure:
    """Return the figure of a tree whose samples are known as `counts`; arguments as those of `draw_tree`."""
    drawing = draw_tree(tree, replace(wording, written=in_font), counts, answer, seen, way)
    ground, height = DARK if dark else LIGHT, drawing.height + (TITLE if title else 0)
    beside = max(0.0, TITLE_LETTERS * text_width(title or "") - drawing.width) / 2
    width = drawing.width + 2 * beside
    scale = min(1.0, WIDEST * PIXELS_PER_INCH / width)
    size = (width * scale / PIXELS_PER_INCH, height * scale / PIXELS_PER_INCH)
    figure = Picture(figsize=size, facecolor=ground.paper)
    axes = figure.add_axes((0.0, 0.0, 1.0, drawing.height / height))
    axes.set(xlim=(-beside, drawing.width + beside), ylim=(drawing.height, 0))
    axes.set_axis_off()
    colours = [_whiter(colour, ground) for colour in class_colours(wording.classes or ("number",))]
    points = LETTERS * scale * 72 / PIXELS_PER_INCH
    for box in drawing.boxes:
        _draw_edge(axes, box, ground, points)
    for box in drawing.boxes:
        _draw_box(axes, box, colours, ground, points)
    if title:
        plain(axes.set_title(in_font(title), fontsize=points * TITLE_LETTERS, color=ground.ink))
    return figure


def _whiter(colour: Colour, ground: Ground) -> Colour:
    red, green, blue = (part + ground.whiter * (1 - part) for part in colour)
    return red, green, blue


def _draw_edge(axes: Axes, box: Box, ground: Ground, points: float) -> None:
    if box.edge is None:
        return
    colour, width = (ground.accent, 2.2) if box.is_lit else (ground.quiet, 0.9)
    curve = Path(box.edge.bends, [Path.MOVETO, *[Path.CURVE4] * 3])
    axes.add_patch(PathPatch(curve, facecolor="none", edgecolor=colour, linewidth=width, zorder=1))
    x, y = box.edge.middle
    behind = {"facecolor": ground.paper, "edgecolor": "none", "pad": 1.5}
    text = axes.text(x, y, box.edge.word, fontsize=points, color=colour if box.is_lit else ground.ink, bbox=behind)
    text.set(ha="center", va="baseline", zorder=2)


def _draw_box(axes: Axes, box: Box, colours: list[Colour], ground: Ground, points: float) -> None:
    own = None if box.label is None else colours[box.label]
    fill = to_rgb(ground.paper) if own is None else _mixed(own, to_rgb(ground.paper))
    edge: Any = ground.accent if box.is_lit else ground.quiet if own is None else own
    style = "round,pad=0,rounding_size=7"
    width = 2.2 if box.is_lit else 0.9
    patch = FancyBboxPatch((box.left, box.y), box.width, box.height, style, facecolor=fill, edgecolor=edge)
    axes.add_patch(patch).set(linewidth=width, zorder=3)
    for line, y in box.text_places:
        text = axes.text(box.x, y, line, fontsize=points, color=ground.ink, ha="center", va="baseline", zorder=5)
        plain(text)
    for bar in box.bars:
        axes.add_patch(
            Rectangle((bar.x, bar.y), bar.width, bar.height, color=colours[bar.label], linewidth=0, zorder=4)
        )
    if box.mark is not None:
        x, top, bottom = box.mark
        axes.plot([x, x], [top, bottom], color=ground.ink, linewidth=1.2, zorder=5)


def _mixed(colour: Colour, paper: Colour) -> Colour:
    red, green, blue = (TINT * a + (1 - TINT) * b for a, b in zip(colour, paper, strict=True))
    return red, green, blue
