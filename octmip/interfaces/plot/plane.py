"""The plane of two features as a tree divides it: each cell a convex polygon, clipped from its parent's."""

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Polygon
from numpy.typing import NDArray

from octmip.errors import ProblemError
from octmip.input.names import shown
from octmip.interfaces.plot.names import drawn, in_font, name_entries, plain
from octmip.interfaces.plot.style import INK, PAPER, Picture, check_names, class_colours, quiet_frame
from octmip.trees.nodes.tree import HyperplaneSplit, Leaf, Node, Split, features_used
from octmip.trees.question.problem import Problem


def partition_figure(
    problem: Problem, tree: Node, features: tuple[int, int] | None = None, title: str | None = None
) -> Figure:
    """Return the plane of two features: samples coloured by class, cells tinted by prediction, split lines.

    Samples that lack a reading of the two have no place in it.

    Each split line ends where its own cell ends; the root's is the thickest. `features` are the two of the plane; left
    out, they are the problem's when it has two, else those that the tree reads.

    Raises
    ------
    ProblemError
        the tree reads other features than two, or predicts a class that the problem lacks.

    Examples
    --------
    >>> problem = Problem([[0, 5], [1, 5], [2, 7]], ["a", "b", "b"], depth=1)
    >>> partition_figure(problem, solve(problem).tree).savefig("plane.svg")
    """
    samples = problem.samples
    check_names(problem, tree)
    pair = _plane(problem, tree, features)
    points = samples.features[:, pair]
    points, codes = points[~np.isnan(points).any(axis=1)], samples.codes[~np.isnan(points).any(axis=1)]
    if len(points) == 0:
        raise ProblemError(
            f"no sample has both readings of {shown(samples.feature_names[pair[0]])} and "
            f"{shown(samples.feature_names[pair[1]])}; expected one at least to draw; name other features"
        )
    low, high = points.min(axis=0), points.max(axis=0)
    margin = 0.04 * np.where(high > low, high - low, 1.0)
    low, high = low - margin, high + margin
    figure = Picture(figsize=(5.6, 4.4), layout="tight")
    axes = figure.add_subplot()
    colours = class_colours(samples.class_names)
    corners = np.array([low, (high[0], low[1]), high, (low[0], high[1])])
    _draw_cell(axes, tree, corners, pair, colours, line_width=2.2)
    order = np.random.default_rng(0).permutation(len(points))  # no class lies wholly on top of another
    x, y = points[order].T
    axes.scatter(x, y, c=np.array(colours)[codes[order]], s=9, linewidths=0.25, edgecolors=PAPER, zorder=2)
    for colour in colours:
        axes.scatter([], [], color=colour, s=22, label="class")
    legend = axes.legend(loc="center left", bbox_to_anchor=(1.01, 0.5), frameon=False, fontsize=8, handletextpad=0.2)
    name_entries(legend, samples.class_names)
    axes.set_xlim(low[0], high[0])
    axes.set_ylim(low[1], high[1])
    plain(axes.set_xlabel(drawn(samples.feature_names[pair[0]], samples.feature_names), color=INK))
    plain(axes.set_ylabel(drawn(samples.feature_names[pair[1]], samples.feature_names), color=INK))
    quiet_frame(axes)
    if title:
        plain(axes.set_title(in_font(title), fontsize=10, color=INK))
    return figure


def _plane(problem: Problem, tree: Node, features: tuple[int, int] | None) -> list[int]:
    used = features_used(tree)
    pair = list(features or (range(2) if problem.samples.n_features == 2 else used))
    if len(pair) != 2 or not set(used) <= set(pair):
        names = [shown(problem.samples.feature_names[feature]) for feature in used]
        count = f"{len(used)} feature{'s' * (len(used) != 1)}"
        raise ProblemError(
            f"the tree reads {count} ({', '.join(names)}); a plane shows a tree over two: name two that "
            "hold them, or solve with a sensor budget of 2"
        )
    return pair


def _draw_cell(
    axes: Axes, node: Node, corners: NDArray[np.float64], pair: list[int], colours: list[Any], line_width: float
) -> None:
    """Draw the subtree of `node` within the convex polygon `corners` (n_corners, 2)."""
    if len(corners) < 3:
        return
    if isinstance(node, Leaf):
        axes.add_patch(Polygon(corners, closed=True, facecolor=colours[node.label], alpha=0.16, linewidth=0, zorder=0))
        return
    height = _height(node, corners, pair)
    crossing = _crossing(corners, height)
    if len(crossing) == 2:
        axes.plot(*np.array(crossing).T, color=INK, linewidth=line_width, zorder=3, solid_capstyle="butt")
    thinner = max(0.8, line_width - 0.6)
    _draw_cell(axes, node.left, _clipped(corners, -height), pair, colours, thinner)
    _draw_cell(axes, node.right, _clipped(corners, height), pair, colours, thinner)


def _height(split: Split | HyperplaneSplit, corners: NDArray[np.float64], pair: list[int]) -> NDArray[np.float64]:
    """Return how far each corner lies on the right side of a split (0 on its line), shape (n_corners,)."""
    if isinstance(split, Split):
        if split.threshold is None:  # the plane holds samples that have both readings
            return np.full(len(corners), -1.0 if split.missing == "right" else 1.0)
        return corners[:, pair.index(split.feature)] - split.threshold
    normal = np.zeros(2)
    normal[[pair.index(feature) for feature in split.features]] = split.coefficients
    return corners @ normal - split.offset


def _crossing(corners: NDArray[np.float64], height: NDArray[np.float64]) -> list[NDArray[np.float64]]:
    """Return where the sides of a polygon pass through height 0: two points, or none."""
    following = np.roll(corners, -1, axis=0), np.roll(height, -1)
    return [
        a + (b - a) * (h / (h - g))
        for a, b, h, g in zip(corners, following[0], height, following[1], strict=True)
        if (h > 0) != (g > 0)
    ]


def _clipped(corners: NDArray[np.float64], height: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the part of a convex polygon where height is 0 or more. Source: Sutherland & Hodgman (1974)."""
    kept: list[NDArray[np.float64]] = []
    for i in range(len(corners)):
        a, b, h, g = corners[i - 1], corners[i], height[i - 1], height[i]
        if (h >= 0) != (g >= 0):
            kept.append(a + (b - a) * (h / (h - g)))
        if g >= 0:
            kept.append(b)
    return np.array(kept).reshape(-1, 2)
