"""Where the nodes of a tree stand in its drawing, in pixels at full size; the template writes it as SVG.

Leaves stand side by side, every split above the middle of its two sides, levels below one another. Widths come from an
estimate of the text that is wide enough for common fonts; longer names end in dots, the title has them whole.
"""

import unicodedata
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from octmip.formats.names import END_ISOLATE, ISOLATE
from octmip.interfaces.report.tree.words import Wording, counted, figure, percent, question, short_name
from octmip.trees.tree import HyperplaneSplit, Leaf, Node, Split, ValueLeaf, leaves

Answer = Callable[[Leaf, Wording], str]
TEXT = 14
"""Size of all text in the drawing [px]."""
CHARACTER, WIDE = 8.0, 16.0
"""Width of a character [px], and of one that is as wide as it is high."""
LINE, PAD, BETWEEN, RISE, MARGIN = 20, 9, 10, 50, 16
LEAST_WIDTH, MOST_WIDTH = 76, 226
BAR = 6
"""Height of the bar that shows the classes of a leaf [px]."""
MOST_TERMS = 4
"""Lines of a split over several features; further ones are counted."""


@dataclass(frozen=True, slots=True)
class Edge:
    """The line from a node's parent to it, and the answer that leads there."""

    path: str
    word: str
    x: float
    y: float


@dataclass(frozen=True, slots=True)
class Box:
    """A node of the drawing.

    Attributes
    ----------
    index
        of the node in preorder.
    x, y
        middle of its upper side [px].
    width, height
        [px].
    lines
        of text.
    title
        all about it in words, for the pointer and for readers of the screen.
    label
        index of the class of a leaf, None for a split.
    bar
        (x, width, class) of the pieces that show which classes a leaf holds.
    edge
        from its parent, None for the root.
    """

    index: int
    x: float
    y: float
    width: float
    height: float
    lines: tuple[str, ...]
    title: str
    label: int | None
    bar: tuple[tuple[float, float, int], ...]
    edge: Edge | None


@dataclass(frozen=True, slots=True)
class Drawing:
    """A tree in its places: its boxes in preorder, and its size [px]."""

    boxes: tuple[Box, ...]
    width: float
    height: float

    @property
    def centre(self) -> float:
        """Where the root stands, as a fraction of the width."""
        return self.boxes[0].x / self.width


@dataclass(slots=True, eq=False)
class _Sized:
    """A node with the size of its box, of all below it, and what it holds."""

    node: Node
    lines: tuple[str, ...]
    title: str
    counts: NDArray[np.int64]
    pieces: Sequence[float] = ()  # of the bar of a leaf: samples of each class, or below and above a number
    sides: "tuple[_Sized, _Sized] | None" = None
    yes_is_left: bool = True
    width: float = 0.0
    height: float = 0.0
    span: float = 0.0


def draw_tree(tree: Node, wording: Wording, counts: NDArray[np.int64], answer: Answer | None = None) -> Drawing:
    """Return the drawing of a tree.

    Parameters
    ----------
    tree, wording
        the tree, and the names in it.
    counts
        samples of each class in each leaf, (n_leaves, n_classes); of numbers one column.
    answer
        the words of a leaf's answer; None: the name of its class, or the number.
    """
    total = max(1, int(counts.sum()))
    root = _sized(tree, _Leaves.of(tree, wording, answer, total), counts)
    leaf_width = max(_leaf_widths(root))
    _spread(root, leaf_width)
    heights = _level_heights(root, 0, {})
    tops = [MARGIN + sum(heights[k] + RISE for k in range(level)) for level in range(len(heights))]
    boxes = _place(root, MARGIN, 0, tops, None)
    return Drawing(tuple(boxes), root.span + 2 * MARGIN, tops[-1] + heights[len(heights) - 1] + MARGIN)


@dataclass(frozen=True, slots=True)
class _Leaves:
    """What the drawing knows of leaves: the words of their answers, all samples, and the ends of their numbers."""

    wording: Wording
    answer: Answer
    total: int
    least: float
    most: float

    @classmethod
    def of(cls, tree: Node, wording: Wording, answer: Answer | None, total: int) -> "_Leaves":
        values = [leaf.value for leaf in leaves(tree) if isinstance(leaf, ValueLeaf)] or [0.0]
        return cls(wording, answer or _answer, total, min(values), max(values))

    def height_of(self, leaf: ValueLeaf) -> float:
        """Return where a number lies between the least and the greatest of all leaves, from 0 to 1."""
        span = self.most / 2 - self.least / 2  # halves do not overflow
        return (leaf.value / 2 - self.least / 2) / span if span > 0 else 1.0


def _answer(leaf: Leaf, wording: Wording) -> str:
    return figure(leaf.value) if isinstance(leaf, ValueLeaf) else short_name(wording.classes[leaf.label])


def _sized(node: Node, known: _Leaves, counts: NDArray[np.int64]) -> _Sized:
    if isinstance(node, Leaf):
        return _sized_leaf(node, known, counts[0])
    n_left, wording = len(leaves(node.left)), known.wording
    sides = (_sized(node.left, known, counts[:n_left]), _sized(node.right, known, counts[n_left:]))
    asked = question(node, wording)
    lines = _few(asked.lines)
    here = counts.sum(axis=0)
    title = f"{asked.text}? {_exactly(node)}{_missing(node, wording)}{counted(int(here.sum()), 'sample')} come here"
    out = _Sized(node, lines, title, here, (), sides, asked.yes_is_left)
    out.width, out.height = _box_width(lines), LINE * len(lines) + PAD
    return out


def _exactly(node: Split | HyperplaneSplit) -> str:
    if not isinstance(node, Split) or not node.threshold or figure(node.threshold) == figure(node.threshold, 17):
        return ""
    return f"(exactly {figure(node.threshold, 17)}) "


def _missing(node: Split | HyperplaneSplit, wording: Wording) -> str:
    """Return where a missing value goes where the question does not say it."""
    is_doubled = isinstance(node, Split) and wording.feature(node.feature).kind == "missing-right"
    is_right = is_doubled or (node.missing == "right" and not _asks_for_gaps(node, wording))
    return "A missing value goes to no. " if is_right else ""


def _asks_for_gaps(node: Split | HyperplaneSplit, wording: Wording) -> bool:
    """Whether the question itself is whether a value is missing, or is one of text, which has an answer of its own."""
    is_text = isinstance(node, Split) and wording.feature(node.feature).kind in ("is", "is-missing", "among")
    return is_text or (isinstance(node, Split) and node.threshold is None)


def _sized_leaf(node: Leaf, known: _Leaves, counts: NDArray[np.int64]) -> _Sized:
    here, name = int(counts.sum()), known.answer(node, known.wording)
    share = percent(round(here / known.total, 3))
    lines: tuple[str, ...] = (_cut(name), f"{here:,}, {share}")
    title = f"Answer: {name}. {counted(here, 'sample')} ({share} of all)"
    pieces = counts.tolist()
    if isinstance(node, ValueLeaf):
        pieces = [] if node.features else [known.height_of(node), 1.0 - known.height_of(node)]
    else:
        wrong = here - int(counts[node.label])
        lines, title = (*lines, f"{wrong:,} wrong"), f"{title}, {wrong:,} of them wrong"
    out = _Sized(node, lines, title, counts, pieces=pieces)
    out.width, out.height = _box_width(lines), LINE * len(lines) + PAD + BAR + 8
    return out


def _few(lines: Sequence[str]) -> tuple[str, ...]:
    if len(lines) > MOST_TERMS + 1:
        lines = [*lines[: MOST_TERMS - 1], f"+ {len(lines) - MOST_TERMS} more", lines[-1]]
    return tuple(_cut(line) for line in lines)


def _box_width(lines: Sequence[str]) -> float:
    return min(MOST_WIDTH, max(LEAST_WIDTH, 2 * PAD + max(_text_width(line) for line in lines)))


def _text_width(text: str) -> float:
    return sum(_character_width(character) for character in text)


def _character_width(character: str) -> float:
    if unicodedata.combining(character) or character in (ISOLATE, END_ISOLATE):
        return 0.0
    is_wide = unicodedata.east_asian_width(character) in "WF" or ord(character) > 0x2E80
    return WIDE if is_wide else 1.6 * CHARACTER if character in "mwMW@%…—" else CHARACTER


def _cut(text: str) -> str:
    """Return a text that fits into the widest box, its end replaced by dots where it does not."""
    room, kept = float(MOST_WIDTH - 2 * PAD), 0
    if _text_width(text) <= room:
        return text
    room -= 1.6 * CHARACTER
    while kept < 60 and _text_width(text[: kept + 1]) <= room:
        kept += 1
    closing = END_ISOLATE if text.startswith(ISOLATE) else ""
    return f"{text[:kept]}{closing}…"


def _leaf_widths(sized: _Sized) -> list[float]:
    if sized.sides is None:
        return [sized.width]
    return [*_leaf_widths(sized.sides[0]), *_leaf_widths(sized.sides[1])]


def _spread(sized: _Sized, leaf_width: float) -> None:
    """Set how wide each node and all below it is."""
    if sized.sides is None:
        sized.width = sized.span = leaf_width
        return
    for side in sized.sides:
        _spread(side, leaf_width)
    sized.span = max(sized.width, sized.sides[0].span + BETWEEN + sized.sides[1].span)


def _level_heights(sized: _Sized, level: int, heights: dict[int, float]) -> dict[int, float]:
    heights[level] = max(heights.get(level, 0.0), sized.height)
    for side in sized.sides or ():
        _level_heights(side, level + 1, heights)
    return heights


def _place(sized: _Sized, left: float, level: int, tops: Sequence[float], edge: Edge | None) -> list[Box]:
    """Return the boxes of a node and all below it, in preorder and numbered from 0; the first is the node's own."""
    below = _sides_placed(sized, left, level, tops)
    x = left + sized.span / 2
    if below:  # over the middle of both sides, as far as its own box has room there
        half = sized.width / 2
        x = min(max((below[0][0].x + below[1][0].x) / 2, left + half), left + sized.span - half)
    label = sized.node.label if isinstance(sized.node, Leaf) else None
    bar = () if label is None else _bar(sized, x)
    own = Box(0, x, tops[level], sized.width, sized.height, sized.lines, sized.title, label, bar, edge)
    boxes = [own]
    for k, side in enumerate(below):
        word = "yes" if (k == 0) == sized.yes_is_left else "no"
        down = _edge(x, own.y + own.height, side[0].x, side[0].y, word)
        first = len(boxes)
        boxes += [replace(box, index=first + n, edge=box.edge if n else down) for n, box in enumerate(side)]
    return boxes


def _sides_placed(sized: _Sized, left: float, level: int, tops: Sequence[float]) -> list[list[Box]]:
    if sized.sides is None:
        return []
    one, other = sized.sides
    start = left + (sized.span - one.span - BETWEEN - other.span) / 2
    return [_place(one, start, level + 1, tops, None), _place(other, start + one.span + BETWEEN, level + 1, tops, None)]


def _edge(x0: float, y0: float, x1: float, y1: float, word: str) -> Edge:
    middle = (y0 + y1) / 2
    path = f"M{x0:.1f} {y0:.1f}C{x0:.1f} {middle:.1f} {x1:.1f} {middle:.1f} {x1:.1f} {y1:.1f}"
    return Edge(path, word, (x0 + x1) / 2, middle + 5)


def _bar(sized: _Sized, x: float) -> tuple[tuple[float, float, int], ...]:
    room, total = sized.width - 2 * PAD, sum(sized.pieces) or 1
    pieces, at = [], x - room / 2
    of_number = isinstance(sized.node, ValueLeaf)
    for label, count in enumerate(sized.pieces[:1] if of_number else sized.pieces):
        if count:
            pieces.append((at, room * count / total, label))
            at += room * count / total
    return tuple(pieces)
