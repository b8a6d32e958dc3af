"""Where the nodes of a tree stand in its drawing, in pixels at full size: what page, notebook and figures draw.

Leaves stand side by side, every split above the middle of its two sides, levels below one another; yes is on the left.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from octmip.interfaces.report.tree.bars import BAR, HISTOGRAM, Bar, histogram_bars, leaf_bars
from octmip.interfaces.report.tree.letters import text_width
from octmip.interfaces.report.tree.node_text import NodeText, leaf_text, split_text
from octmip.interfaces.report.tree.seen import Histogram, Seen
from octmip.interfaces.report.tree.words import ROOM, Wording, answered, question
from octmip.trees.nodes.tree import Leaf, Node, ValueLeaf, leaves

Answer = Callable[[Leaf, Wording], str]
TEXT = 14
"""Size of all text in the drawing [px]."""
LINE, FIRST_LINE = 20, 22
"""From one line of text to the next, and from the upper side of a box to its first [px]."""
PAD, BETWEEN, RISE, MARGIN = 9, 10, 50, 16
LEAST_WIDTH, MOST_WIDTH, HISTOGRAM_WIDTH = 76, ROOM + 2 * PAD, 134
BELOW = 7
"""Free below the bars of a box [px]."""


@dataclass(frozen=True, slots=True)
class Edge:
    """The line from a node's parent (x0, y0) to it (x1, y1), and the answer that leads there."""

    x0: float
    y0: float
    x1: float
    y1: float
    word: str

    @property
    def bends(self) -> tuple[tuple[float, float], ...]:
        """The four points of its Bézier curve."""
        middle = (self.y0 + self.y1) / 2
        return ((self.x0, self.y0), (self.x0, middle), (self.x1, middle), (self.x1, self.y1))

    @property
    def middle(self) -> tuple[float, float]:
        """Where its word stands: the middle of the foot of the text."""
        return (self.x0 + self.x1) / 2, (self.y0 + self.y1) / 2 + 5


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
    text
        its lines; its title is for the pointer and for readers of the screen.
    label
        index of the class of a leaf, None for a split.
    bars
        which classes a leaf holds, or where its number lies; at a split the histogram.
    mark
        (x, upper end, lower end) of the line that marks the threshold in the histogram; None without.
    edge
        from its parent, None for the root.
    is_lit
        whether the sample whose way is shown passes it.
    """

    index: int
    x: float
    y: float
    width: float
    height: float
    text: NodeText
    label: int | None
    bars: tuple[Bar, ...]
    mark: tuple[float, float, float] | None
    edge: Edge | None
    is_lit: bool

    @property
    def left(self) -> float:
        """Where its left side is."""
        return self.x - self.width / 2

    @property
    def text_places(self) -> list[tuple[str, float]]:
        """Its lines, each with the height of its foot."""
        return [(line, self.y + FIRST_LINE + LINE * k) for k, line in enumerate(self.text.lines)]


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


def draw_tree(
    tree: Node,
    wording: Wording,
    counts: NDArray[np.int64],
    answer: Answer | None = None,
    seen: Seen | None = None,
    way: int | None = None,
) -> Drawing:
    """Return the drawing of a tree.

    Parameters
    ----------
    tree, wording
        the tree, and the names in it.
    counts
        samples of each class in each leaf, (n_leaves, n_classes); of numbers one column.
    answer
        the words of a leaf's answer; None: the name of its class, or the number.
    seen
        the samples, for the spread of numbers in the leaves and for histograms; None: without them.
    way
        the leaf, counted from the left, whose way from the root is lit; None: no way.
    """
    values = [leaf.value for leaf in leaves(tree) if isinstance(leaf, ValueLeaf)] or [0.0]
    known = _Drawn(wording, answer or _answer, counts, seen, way, min(values), max(values))
    root = _sized(tree, known, 0)
    _spread(root, max(_leaf_widths(root)))
    heights = _level_heights(root, 0, {})
    tops = [MARGIN + sum(heights[k] + RISE for k in range(level)) for level in range(len(heights))]
    boxes = _place(root, MARGIN, 0, tops, None)
    return Drawing(tuple(boxes), root.span + 2 * MARGIN, tops[-1] + heights[len(heights) - 1] + MARGIN)


def _answer(leaf: Leaf, wording: Wording) -> str:
    return answered(leaf.value) if isinstance(leaf, ValueLeaf) else wording.short(wording.classes[leaf.label])


@dataclass(frozen=True, slots=True, eq=False)
class _Drawn:
    """What is drawn of every node, and the ends of the leaves' numbers."""

    wording: Wording
    answer: Answer
    counts: NDArray[np.int64]
    seen: Seen | None
    way: int | None
    least: float
    most: float

    def height_of(self, leaf: ValueLeaf) -> float:
        """Return where a number lies between the least and the greatest of all leaves, from 0 to 1."""
        span = self.most / 2 - self.least / 2  # halves do not overflow
        return (leaf.value / 2 - self.least / 2) / span if span > 0 else 1.0

    def is_lit(self, first: int, end: int) -> bool:
        """Whether the way leads through the node whose leaves are first..end-1."""
        return self.way is not None and first <= self.way < end


@dataclass(slots=True, eq=False)
class _Sized:
    """A node with the size of its box, of all below it, and what it holds; `sides` in the order of the tree."""

    node: Node
    text: NodeText
    is_lit: bool
    pieces: Sequence[float] = ()  # of the bar of a leaf: shares of the classes, or the height of a number
    histogram: Histogram | None = None
    sides: "list[_Sized]" = field(default_factory=list)
    yes_is_left: bool = True
    width: float = 0.0
    height: float = 0.0
    span: float = 0.0


def _sized(node: Node, known: _Drawn, first: int) -> _Sized:
    """Return a node whose leaves begin with the `first` from the left."""
    if isinstance(node, Leaf):
        return _sized_leaf(node, known, first)
    middle = first + len(leaves(node.left))
    end = middle + len(leaves(node.right))
    asked = question(node, known.wording)
    text = split_text(node, asked, known.wording, int(known.counts[first:end].sum()))
    out = _Sized(node, text, known.is_lit(first, end), yes_is_left=asked.yes_is_left)
    out.sides = [_sized(node.left, known, first), _sized(node.right, known, middle)]
    histogram = known.seen.histogram(node, first, middle, end) if known.seen else None
    out.histogram = histogram if histogram is None or asked.yes_is_left else histogram.mirrored()
    out.width, out.height = _box_width(text.lines), LINE * len(text.lines) + PAD
    if histogram:
        out.width, out.height = max(out.width, HISTOGRAM_WIDTH), out.height + HISTOGRAM + BELOW + 4
    return out


def _sized_leaf(node: Leaf, known: _Drawn, index: int) -> _Sized:
    counts = known.counts[index]
    spread = known.seen.spread(index) if known.seen else None
    name, total = known.answer(node, known.wording), int(known.counts.sum())
    text = leaf_text(node, name, known.wording, counts, total, spread)
    pieces = (counts / max(1, counts.sum())).tolist()
    if isinstance(node, ValueLeaf):
        pieces = [] if node.features else [known.height_of(node)]
    out = _Sized(node, text, known.is_lit(index, index + 1), pieces)
    out.width, out.height = _box_width(text.lines), LINE * len(text.lines) + PAD + BAR + BELOW + 1
    return out


def _box_width(lines: Sequence[str]) -> float:
    return min(MOST_WIDTH, max(LEAST_WIDTH, 2 * PAD + max(text_width(line) for line in lines)))


def _leaf_widths(sized: _Sized) -> list[float]:
    return [width for side in sized.sides for width in _leaf_widths(side)] or [sized.width]


def _spread(sized: _Sized, leaf_width: float) -> None:
    """Set how wide each node and all below it is."""
    if not sized.sides:
        sized.width = sized.span = leaf_width
        return
    for side in sized.sides:
        _spread(side, leaf_width)
    sized.span = max(sized.width, sized.sides[0].span + BETWEEN + sized.sides[1].span)


def _level_heights(sized: _Sized, level: int, heights: dict[int, float]) -> dict[int, float]:
    heights[level] = max(heights.get(level, 0.0), sized.height)
    for side in sized.sides:
        _level_heights(side, level + 1, heights)
    return heights


def _place(sized: _Sized, left: float, level: int, tops: Sequence[float], edge: Edge | None) -> list[Box]:
    """Return the boxes of a node and all below it, in preorder and numbered from 0; the first is the node's own."""
    below = _sides_placed(sized, left, level, tops)
    x = left + sized.span / 2
    if below:  # over the middle of both sides, as far as its own box has room there
        half = sized.width / 2
        x = min(max((below[0][0].x + below[1][0].x) / 2, left + half), left + sized.span - half)
    y, label = tops[level], sized.node.label if isinstance(sized.node, Leaf) else None
    room, foot = sized.width - 2 * PAD, y + sized.height - BELOW
    bars, mark = leaf_bars(sized.pieces, x, foot, room), None
    if sized.histogram:
        bars, mark = histogram_bars(sized.histogram, x, foot, room)
    own = Box(0, x, y, sized.width, sized.height, sized.text, label, bars, mark, edge, sized.is_lit)
    boxes = [own]
    for k, side in enumerate(below):
        word = "yes" if (k == 0) == sized.yes_is_left else "no"
        down = Edge(x, y + own.height, side[0].x, side[0].y, word)
        first = len(boxes)
        boxes += [replace(box, index=first + n, edge=box.edge if n else down) for n, box in enumerate(side)]
    return boxes


def _sides_placed(sized: _Sized, left: float, level: int, tops: Sequence[float]) -> list[list[Box]]:
    """Return the boxes of both sides in the order of the tree; that of yes stands on the left.

    The tree itself has yes on the right where it asks for one value of a text, of which it reads 1 for yes, 0 for no.
    """
    order = sized.sides if sized.yes_is_left else sized.sides[::-1]
    at = left + (sized.span - sum(side.span for side in order) - BETWEEN) / 2
    placed = []
    for side in order:
        placed.append(_place(side, at, level + 1, tops, None))
        at += side.span + BETWEEN
    return (placed if sized.yes_is_left else placed[::-1]) if sized.sides else []
