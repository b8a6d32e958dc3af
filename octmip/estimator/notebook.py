"""The picture of a fitted tree in a notebook: an SVG of its own, which needs no package and follows the page's colours.

Leaves stand side by side, every split above the middle of its two sides. All boxes are as wide as the longest text.
"""

from collections.abc import Callable
from dataclasses import dataclass
from html import escape

from octmip.tree import HyperplaneSplit, Leaf, Node, Split, depth, leaves

CHARACTER, LINE, MARGIN = 7.2, 16.0, 12.0
"""Width of a character, height of a line, and free space around a box [px], at a type of 13 px."""
LEVEL = 44.0
"""Height between the boxes of two levels [px]."""
MOST_LEAVES = 64
"""With more leaves the picture is too wide to be read, and the tree is shown as text."""
COLOURS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#8c6d31", "#7f7f7f")
"""Of the classes, apart for colour-blind readers too. Source: Okabe & Ito (2008), and two more."""


@dataclass(frozen=True, slots=True)
class _Box:
    """A node in the picture: x is the middle, y the upper edge [px]; `label` is that of a leaf."""

    x: float
    y: float
    text: tuple[str, ...]
    label: int | None
    sides: tuple["_Box", ...] = ()


def tree_svg(
    tree: Node,
    question: Callable[[Split | HyperplaneSplit], str],
    decision: Callable[[Leaf], str],
) -> str:
    """Return the drawing of a tree as an SVG element; `decision` is called for the leaves from the left.

    Texts may have several lines. Yes (left) and no (right) stand on the edges of the root.
    """
    texts = {id(node): tuple(question(node).splitlines()) for node in _splits(tree)}
    answers = [tuple(decision(leaf).splitlines()) for leaf in leaves(tree)]
    lines = [*texts.values(), *answers]
    width = CHARACTER * max(len(line) for text in lines for line in text) + MARGIN
    height = LINE * max(len(text) for text in lines) + MARGIN
    root = _place(tree, texts, iter(enumerate(answers)), width + MARGIN, height + LEVEL, 0)
    size = (len(answers) * (width + MARGIN) + 2, depth(tree) * (height + LEVEL) + height + 2)
    parts = [part for box in _walk(root) for part in _drawn(box, width, height)]
    if root.sides:
        parts += [_word(root, side, word, height) for side, word in zip(root.sides, ("yes", "no"), strict=True)]
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" role="img" aria-label="the fitted tree" width="{size[0]:.0f}" '
        f'height="{size[1]:.0f}" font-family="sans-serif" font-size="13" text-anchor="middle" fill="currentColor">'
        f"{''.join(parts)}</svg>"
    )


def _splits(tree: Node) -> list[Split | HyperplaneSplit]:
    return [] if isinstance(tree, Leaf) else [tree, *_splits(tree.left), *_splits(tree.right)]


def _place(
    node: Node,
    texts: dict[int, tuple[str, ...]],
    answers: "enumerate[tuple[str, ...]]",
    step: float,
    level: float,
    row: int,
) -> _Box:
    y = row * level + 1
    if isinstance(node, Leaf):
        k, text = next(answers)
        return _Box((k + 0.5) * step, y, text, node.label)
    sides = tuple(_place(side, texts, answers, step, level, row + 1) for side in (node.left, node.right))
    return _Box((sides[0].x + sides[1].x) / 2, y, texts[id(node)], None, sides)


def _walk(box: _Box) -> list[_Box]:
    return [box, *(below for side in box.sides for below in _walk(side))]


def _drawn(box: _Box, width: float, height: float) -> list[str]:
    parts = [
        f'<path d="M{box.x:.1f} {box.y + height:.1f}L{side.x:.1f} {side.y:.1f}" stroke="currentColor" '
        'stroke-opacity=".5" fill="none"/>'
        for side in box.sides
    ]
    fill = "none" if box.label is None else COLOURS[box.label % len(COLOURS)]
    parts.append(
        f'<rect x="{box.x - width / 2:.1f}" y="{box.y:.1f}" width="{width:.1f}" height="{height:.1f}" rx="6" '
        f'stroke="{"currentColor" if box.label is None else fill}" fill="{fill}" fill-opacity=".18"/>'
    )
    top = box.y + height / 2 - LINE * (len(box.text) - 1) / 2 + 4.5
    parts += [
        f'<text x="{box.x:.1f}" y="{top + LINE * k:.1f}">{escape(line)}</text>' for k, line in enumerate(box.text)
    ]
    return parts


def _word(root: _Box, side: _Box, word: str, height: float) -> str:
    x, y = (root.x + side.x) / 2, (root.y + height + side.y) / 2
    shift = -14 if side.x < root.x else 14
    return f'<text x="{x + shift:.1f}" y="{y - 2:.1f}" font-size="11" font-style="italic">{word}</text>'


def notebook_html(picture: str, verdict: str) -> str:
    """Return the picture in a frame that scrolls where it is wider than the cell, with the verdict below it."""
    below = f'<div style="margin-top:4px;font-family:sans-serif;font-size:13px">{escape(verdict)}</div>'
    return f'<div style="overflow-x:auto;margin-top:8px">{picture}</div>{below}'
