"""Figures: a tree, the partition of a two-feature plane, bound and gap over time.

Every function returns a `matplotlib.figure.Figure` made without pyplot: no window, no global state, any thread. Save
it with ``figure.savefig``. Classes that are numbers (a loss of stiffness of 0, 20, 40 percent) get the colours of one
scale in their order, other classes get colours that are told apart by colour-blind readers too.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure
from matplotlib.patches import FancyBboxPatch, Polygon, Rectangle
from numpy.typing import NDArray

from octmip.errors import ProblemError
from octmip.problem import Problem
from octmip.solution import Progress
from octmip.tree import HyperplaneSplit, Leaf, Node, Split, depth, features_used, leaf_index, leaves, nodes

INK, QUIET, PAPER = "#1f2933", "#7b8794", "#ffffff"
# Okabe & Ito (2008), yellow last: distinct for all common kinds of colour blindness.
DISTINCT = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#56b4e9", "#e69f00", "#999999", "#f0e442")
MINUS = "\N{MINUS SIGN}"
NODE_WIDTH, NODE_HEIGHT, BAR_HEIGHT = 0.86, 0.5, 0.09
LINE_LENGTH = 16  # characters that a node holds at full size of type


def class_colours(class_names: Sequence[Any]) -> list[tuple[float, float, float]]:
    """Return one colour for each class: a scale in order when all are numbers, else distinct ones."""
    k = len(class_names)
    is_ordered = k > 2 and all(isinstance(name, int | float) and not isinstance(name, bool) for name in class_names)
    if is_ordered or k > len(DISTINCT):
        rank = np.argsort(np.argsort(class_names)) if is_ordered else np.arange(k)
        scale = matplotlib.colormaps["viridis"]
        return [to_rgb(scale(0.02 + 0.86 * r / (k - 1))) for r in rank.tolist()]
    return [to_rgb(colour) for colour in DISTINCT[:k]]


def split_text(split: Split | HyperplaneSplit, feature_names: Sequence[str]) -> str:
    """Return the condition for going left, as ``g01 <= 2.5`` or ``0.5 g01 - 2 g02 <= 1`` over lines."""
    if isinstance(split, Split):
        return f"{feature_names[split.feature]} ≤ {split.threshold:.5g}"
    terms = ""
    for feature, coefficient in zip(split.features, split.coefficients, strict=True):
        sign = MINUS if coefficient < 0 else "+" if terms else ""
        size = "" if abs(coefficient) == 1 else f"{abs(coefficient):.3g} "
        terms += f"{sign} {size}{feature_names[feature]}\n"
    return f"{terms.strip()}\n≤ {split.offset:.4g}"


@dataclass(frozen=True, slots=True, eq=False)
class _Place:
    """Where a node stands in the drawing, x counted in leaves and y in levels below the root."""

    node: Node
    x: float
    y: float
    children: tuple["_Place", ...]

    def walk(self) -> Iterator["_Place"]:
        yield self
        for child in self.children:
            yield from child.walk()


def _places(node: Node, level: int, first_leaf: int) -> _Place:
    if isinstance(node, Leaf):
        return _Place(node, float(first_leaf), float(level), ())
    left = _places(node.left, level + 1, first_leaf)
    right = _places(node.right, level + 1, first_leaf + len(leaves(node.left)))
    return _Place(node, (left.x + right.x) / 2, float(level), (left, right))


def tree_figure(problem: Problem, tree: Node, title: str | None = None) -> Figure:
    """Return a drawing of a tree: its splits, and its leaves with class, samples and a bar of their classes.

    Yes (left) and no (right) are written on the edges of the root.

    Raises:
        ProblemError: the tree reads a feature or predicts a class that the problem lacks.
    """
    _check_names(problem, tree)
    counts = np.zeros((len(leaves(tree)), problem.n_classes), dtype=np.int64)
    np.add.at(counts, (leaf_index(tree, problem.features), problem.codes), 1)
    return counted_tree_figure(tree, counts, problem.feature_names, problem.class_names, title)


def counted_tree_figure(
    tree: Node,
    counts: NDArray[np.int64],
    feature_names: Sequence[str],
    class_names: Sequence[Any],
    title: str | None = None,
) -> Figure:
    """Return the drawing of a tree whose samples are known as `counts`, (n_leaves, n_classes), leaves from the left."""
    place = _places(tree, 0, 0)
    size = 1.25 + 0.35 * max(_lines(node) - 1 for node in nodes(tree))
    figure = Figure(figsize=(max(3.0, 1.2 * len(leaves(tree))), max(1.4, size * (depth(tree) + 0.8))), layout="tight")
    axes = figure.add_subplot()
    rows = iter(counts)
    for here in place.walk():
        _draw_edges(axes, here, is_root=here is place)
        if isinstance(here.node, Leaf):
            _draw_leaf(axes, here, next(rows), class_names)
        else:
            _draw_box(axes, here, split_text(here.node, feature_names), PAPER)
    axes.set_xlim(-0.55, len(leaves(tree)) - 0.45)
    axes.set_ylim(depth(tree) + 0.5, -0.45)
    axes.set_axis_off()
    if title:
        axes.set_title(title, fontsize=10, color=INK)
    return figure


def _lines(node: Node) -> int:
    return len(node.features) + 1 if isinstance(node, HyperplaneSplit) else 1


def _draw_edges(axes: Axes, place: _Place, is_root: bool) -> None:
    for child, word, side in zip(place.children, ("yes", "no"), ("right", "left"), strict=False):
        axes.plot([place.x, child.x], [place.y, child.y], color=QUIET, linewidth=1.0, zorder=1)
        if is_root:
            x, y = (place.x + child.x) / 2, (place.y + child.y) / 2
            axes.text(x, y - 0.04, f" {word} ", ha=side, va="bottom", fontsize=7.5, color=QUIET, style="italic")


def _draw_box(axes: Axes, place: _Place, text: str, fill: Any, edge: Any = INK) -> None:
    height = NODE_HEIGHT if text.count("\n") < 2 else min(0.82, 0.17 * (text.count("\n") + 1))
    corner = (place.x - NODE_WIDTH / 2, place.y - height / 2)
    style = "round,pad=0,rounding_size=0.08"
    box = FancyBboxPatch(corner, NODE_WIDTH, height, style, facecolor=fill, edgecolor=edge, linewidth=0.9, zorder=2)
    axes.add_patch(box)
    ink = PAPER if _luminance(fill) < 0.45 else INK
    longest = max(len(line) for line in text.splitlines())
    font = 8.0 if longest <= LINE_LENGTH else max(4.0, 8.0 * LINE_LENGTH / longest)
    axes.text(place.x, place.y, text, ha="center", va="center", fontsize=font, color=ink, zorder=3, linespacing=1.25)


def _draw_leaf(axes: Axes, place: _Place, counts: NDArray[np.int64], class_names: Sequence[Any]) -> None:
    assert isinstance(place.node, Leaf)
    colours, label, total = class_colours(class_names), place.node.label, int(counts.sum())
    wrong = total - int(counts[label])
    text = f"{class_names[label]}\n{total}" + (f", {wrong} wrong" if wrong else "")
    _draw_box(axes, place, text, colours[label], edge=colours[label])
    left = place.x - NODE_WIDTH / 2
    for colour, count in zip(colours, counts.tolist(), strict=True):
        width = NODE_WIDTH * count / max(total, 1)
        axes.add_patch(
            Rectangle((left, place.y + NODE_HEIGHT / 2 + 0.05), width, BAR_HEIGHT, color=colour, linewidth=0)
        )
        left += width


def _luminance(colour: Any) -> float:
    red, green, blue = to_rgb(colour)
    return 0.299 * red + 0.587 * green + 0.114 * blue


def partition_figure(
    problem: Problem, tree: Node, features: tuple[int, int] | None = None, title: str | None = None
) -> Figure:
    """Return the plane of two features: samples coloured by class, cells tinted by prediction, split lines.

    Each split line ends where its own cell ends; the root's is the thickest. `features` are the two of the plane; left
    out, they are the problem's when it has two, else those that the tree reads.

    Raises:
        ProblemError: the tree reads other features than two, or predicts a class that the problem lacks.
    """
    _check_names(problem, tree)
    pair = _plane(problem, tree, features)
    points = problem.features[:, pair]
    low, high = points.min(axis=0), points.max(axis=0)
    margin = 0.04 * np.where(high > low, high - low, 1.0)
    low, high = low - margin, high + margin
    figure = Figure(figsize=(5.6, 4.4), layout="tight")
    axes = figure.add_subplot()
    colours = class_colours(problem.class_names)
    corners = np.array([low, (high[0], low[1]), high, (low[0], high[1])])
    _draw_cell(axes, tree, corners, pair, colours, line_width=2.2)
    order = np.random.default_rng(0).permutation(problem.n_samples)  # no class lies wholly on top of another
    x, y = points[order].T
    axes.scatter(x, y, c=np.array(colours)[problem.codes[order]], s=9, linewidths=0.25, edgecolors=PAPER, zorder=2)
    for colour, name in zip(colours, problem.class_names, strict=True):
        axes.scatter([], [], color=colour, s=22, label=str(name))
    axes.legend(loc="center left", bbox_to_anchor=(1.01, 0.5), frameon=False, fontsize=8, handletextpad=0.2)
    axes.set_xlim(low[0], high[0])
    axes.set_ylim(low[1], high[1])
    axes.set_xlabel(problem.feature_names[pair[0]], color=INK)
    axes.set_ylabel(problem.feature_names[pair[1]], color=INK)
    _quiet_frame(axes)
    if title:
        axes.set_title(title, fontsize=10, color=INK)
    return figure


def _plane(problem: Problem, tree: Node, features: tuple[int, int] | None) -> list[int]:
    used = features_used(tree)
    pair = list(features or (range(2) if problem.n_features == 2 else used))
    if len(pair) != 2 or not set(used) <= set(pair):
        names = [problem.feature_names[feature] for feature in used]
        raise ProblemError(
            f"the tree reads {len(used)} features ({', '.join(names)}); a plane shows a tree over two: name two that "
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


def progress_figure(progress: Sequence[Progress], title: str | None = None) -> Figure:
    """Return objective and bound over the seconds of a solver's run, the gap between them shaded.

    Raises:
        ProblemError: there is no progress to draw.
    """
    if not progress:
        raise ProblemError("no progress was recorded; give solve a progress callback that keeps what it is told")
    seconds = np.array([state.seconds for state in progress])
    objective = np.array([state.objective for state in progress])
    bound = np.array([state.bound for state in progress])
    figure = Figure(figsize=(5.6, 3.2), layout="tight")
    axes = figure.add_subplot()
    bound, objective = np.where(np.isfinite(bound), bound, np.nan), np.where(np.isfinite(objective), objective, np.nan)
    axes.fill_between(seconds, bound, objective, step="post", color=DISTINCT[0], alpha=0.12, linewidth=0)
    axes.step(seconds, objective, where="post", color=DISTINCT[1], label="best tree")
    axes.step(seconds, bound, where="post", color=DISTINCT[0], label="proven bound")
    axes.set_xlabel("seconds", color=INK)
    axes.set_ylabel("objective", color=INK)
    axes.legend(frameon=False, fontsize=8)
    _quiet_frame(axes)
    if title:
        axes.set_title(title, fontsize=10, color=INK)
    return figure


def frontier_figure(
    values: Sequence[float], objectives: Sequence[float], bounds: Sequence[float], name: str, title: str | None = None
) -> Figure:
    """Return objectives and bounds against what was varied, the gaps between them as bars; `name` is of the values.

    Raises:
        ProblemError: there is no point to draw.
    """
    if not values:
        raise ProblemError("the frontier has no points; give it at least one value")
    figure = Figure(figsize=(5.6, 3.2), layout="tight")
    axes = figure.add_subplot()
    proven = np.where(np.isfinite(bounds), bounds, np.nan)
    axes.vlines(values, proven, objectives, color=DISTINCT[0], alpha=0.35, linewidth=5)
    axes.plot(values, objectives, color=DISTINCT[1], marker="o", markersize=4, label="best tree")
    axes.plot(values, proven, color=DISTINCT[0], marker="_", linewidth=0, label="proven bound")
    axes.set_ylim(bottom=0)
    if all(value == round(value) for value in values) and len(values) < 20:
        axes.set_xticks(values)
    axes.set_xlabel(name, color=INK)
    axes.set_ylabel("objective", color=INK)
    axes.legend(frameon=False, fontsize=8)
    _quiet_frame(axes)
    if title:
        axes.set_title(title, fontsize=10, color=INK)
    return figure


def _quiet_frame(axes: Axes) -> None:
    axes.tick_params(colors=QUIET, labelsize=8, labelcolor=INK)
    for side in axes.spines.values():
        side.set_color(QUIET)
        side.set_linewidth(0.7)


def _check_names(problem: Problem, tree: Node) -> None:
    highest = max((*features_used(tree), -1))
    label = max(leaf.label for leaf in leaves(tree))
    if highest >= problem.n_features or label >= problem.n_classes:
        raise ProblemError(
            f"the tree reads feature {highest} and predicts class {label} but the problem has {problem.n_features} "
            f"features and {problem.n_classes} classes; draw it with the problem that it was found for"
        )
