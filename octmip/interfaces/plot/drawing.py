"""The drawing of a tree: splits, edges, leaves with class, samples and a bar of their classes."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import FancyBboxPatch, Rectangle
from numpy.typing import NDArray

from octmip.formats.columns import Columns
from octmip.formats.tree_file import leaf_counts
from octmip.interfaces.plot.names import drawn, plain
from octmip.interfaces.plot.style import INK, PAPER, QUIET, check_names, class_colours, luminance, titled
from octmip.trees.problem import Problem
from octmip.trees.tree import HyperplaneSplit, Leaf, Node, Split, ValueLeaf, depth, leaves, nodes, prediction

MINUS = "\N{MINUS SIGN}"
NODE_WIDTH, NODE_HEIGHT, BAR_HEIGHT = 0.86, 0.5, 0.09
LINE_LENGTH = 16  # characters that a node holds at full size of type
WIDEST = 200.0  # inches: PNG files and their memory end soon after, so nodes of wider trees draw nearer


def split_text(split: Split | HyperplaneSplit, feature_names: Sequence[str], columns: Columns | None = None) -> str:
    """Return the condition for going left, as ``g01 <= 2.5`` or ``0.5 g01 - 2 g02 <= 1`` over lines.

    With `columns` it is said of those that the features were made from: "colour is not red".
    """
    if isinstance(split, Split) and columns is not None:
        words = drawn(columns.left_words(split, "{:.5g}".format)).replace("<=", "≤")
        return f"{words.removesuffix(' or missing')}\nor missing" if words.endswith(" or missing") else words
    or_missing = "\nor missing" if split.missing == "left" else ""
    if isinstance(split, Split):
        name = drawn(feature_names[split.feature])
        if split.threshold is None:
            return f"{name} is {'' if or_missing else 'not '}missing"
        return f"{name} ≤ {split.threshold:.5g}{or_missing}"
    terms = ""
    for feature, coefficient in zip(split.features, split.coefficients, strict=True):
        sign = MINUS if coefficient < 0 else "+" if terms else ""
        size = "" if abs(coefficient) == 1 else f"{abs(coefficient):.3g} "
        terms += f"{sign} {size}{drawn(feature_names[feature])}\n"
    return f"{terms.strip()}\n≤ {split.offset:.4g}{or_missing}"


@dataclass(frozen=True, slots=True, eq=False)
class _Place:
    """Position of a node in the drawing, x counted in leaves and y in levels below the root."""

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


def tree_figure(problem: Problem, tree: Node, title: str | None = None, columns: Columns | None = None) -> Figure:
    """Return a drawing of a tree: its splits, and its leaves with class or number, samples and a bar of their classes.

    Yes (left) and no (right) are written on the edges of the root. `columns` are those that the features were made
    from, in whose words the splits are then written.

    Raises
    ------
    ProblemError
        the tree reads a feature or predicts a class that the problem lacks.
    """
    check_names(problem, tree)
    return counted_tree_figure(
        tree, leaf_counts(problem, tree), problem.feature_names, problem.class_names, title, columns
    )


def counted_tree_figure(
    tree: Node,
    counts: NDArray[np.int64],
    feature_names: Sequence[str],
    class_names: Sequence[Any],
    title: str | None = None,
    columns: Columns | None = None,
) -> Figure:
    """Return the drawing of a tree whose samples are known as `counts`, those of `leaf_counts`."""
    place = _places(tree, 0, 0)
    size = 1.25 + 0.35 * max(_lines(node) - 1 for node in nodes(tree))
    width = min(WIDEST, max(3.0, 1.2 * len(leaves(tree))))
    figure = Figure(figsize=(width, max(1.4, size * (depth(tree) + 0.8))), layout="tight")
    axes = figure.add_subplot()
    rows = iter(counts)
    for here in place.walk():
        _draw_edges(axes, here, is_root=here is place)
        if isinstance(here.node, Leaf):
            _draw_leaf(axes, here, next(rows), feature_names, class_names)
        else:
            _draw_box(axes, here, split_text(here.node, feature_names, columns), PAPER)
    axes.set_xlim(-0.55, len(leaves(tree)) - 0.45)
    axes.set_ylim(depth(tree) + 0.5, -0.45)
    axes.set_axis_off()
    return titled(figure, axes, title)


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
    ink = PAPER if luminance(fill) < 0.45 else INK
    longest = max(len(line) for line in text.splitlines())
    font = 8.0 if longest <= LINE_LENGTH else max(4.0, 8.0 * LINE_LENGTH / longest)
    label = axes.text(place.x, place.y, text, fontsize=font, color=ink, zorder=3, linespacing=1.25)
    plain(label).set(ha="center", va="center")


def _draw_leaf(
    axes: Axes, place: _Place, counts: NDArray[np.int64], feature_names: Sequence[str], class_names: Sequence[Any]
) -> None:
    assert isinstance(place.node, Leaf)
    if isinstance(place.node, ValueLeaf):
        said = prediction(place.node, lambda feature: drawn(feature_names[feature]))
        _draw_box(axes, place, f"{said}\n{int(counts.sum())}", PAPER, edge=QUIET)
        return
    colours, label, total = class_colours(class_names), place.node.label, int(counts.sum())
    wrong = total - int(counts[label])
    text = f"{drawn(class_names[label])}\n{total}" + (f", {wrong} wrong" if wrong else "")
    _draw_box(axes, place, text, colours[label], edge=colours[label])
    left = place.x - NODE_WIDTH / 2
    for colour, count in zip(colours, counts.tolist(), strict=True):
        if not count:
            continue
        width = NODE_WIDTH * count / total
        axes.add_patch(
            Rectangle((left, place.y + NODE_HEIGHT / 2 + 0.05), width, BAR_HEIGHT, color=colour, linewidth=0)
        )
        left += width
