"""The drawing of a tree as SVG, for a notebook and for the page.

The attributes hold by themselves and follow the colour of the text around; a page's style sheet overrides them by the
classes of the elements.
"""

from octmip.input.names import html_text
from octmip.interfaces.report.tree.drawing import TEXT, Box, Drawing

COLOURS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#8c6d31", "#7f7f7f")
"""Of the classes, apart for colour-blind readers too. Source: Okabe & Ito (2008), and two more."""
RING = 4
"""From a box to the ring that shows the keyboard's place [px]."""


def drawing_svg(drawing: Drawing, label: str = "the fitted tree", id: str = "") -> str:
    """Return a drawing as an SVG element.

    Parameters
    ----------
    drawing, label
        the drawing, and what a reader of the screen calls it.
    id
        of the element, whose nodes are then buttons of the page; "": a mere picture.
    """
    width, height = f"{drawing.width:.0f}", f"{drawing.height:.0f}"
    boxes = "".join(_edge(box) for box in drawing.boxes) + "".join(_box(box, bool(id)) for box in drawing.boxes)
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" {f"""id="{id}" role="group" """ if id else """role="img" """}'
        f'aria-label="{html_text(label)}" width="{width}" height="{height}" viewBox="0 0 {width} {height}" '
        f'data-centre="{drawing.centre:.4f}" font-family="sans-serif" font-size="{TEXT}" text-anchor="middle" '
        f'fill="currentColor">{boxes}</svg>'
    )


def _edge(box: Box) -> str:
    if box.edge is None:
        return ""
    start, *bends = [f"{x:.1f} {y:.1f}" for x, y in box.edge.bends]
    x, y = box.edge.middle
    stroke = 'stroke-width="3"' if box.is_lit else 'stroke-opacity=".5"'
    return (
        f'<g class="edge{_lit(box)}" data-to="{box.index}"><path d="M{start}C{" ".join(bends)}" fill="none" '
        f'stroke="currentColor" {stroke}/><text x="{x:.1f}" y="{y:.1f}" fill-opacity=".75">{box.edge.word}</text></g>'
    )


def _box(box: Box, is_button: bool) -> str:
    title, is_leaf = html_text(box.text.title), box.label is not None
    fill = "none" if box.label is None else _colour(box.label)
    role = f' role="button" tabindex="{"-1" if box.edge else "0"}"' if is_button else ""  # its name: title and lines
    ring = f'<rect class="focus-ring" {_sides(box, RING)} rx="10"/>' if is_button else ""
    stroke = f'stroke="{"currentColor" if box.is_lit or not is_leaf else fill}" stroke-width="{3 if box.is_lit else 1}"'
    lines = "".join(
        f'<text{_kind(box, k)} x="{box.x:.1f}" y="{y:.1f}">{html_text(line)}</text>'
        for k, (line, y) in enumerate(box.text_places)
    )
    return (
        f'<g class="node {"leaf" if is_leaf else "split"}{_lit(box)}" data-node="{box.index}"{role}>'
        f'<title>{title}</title>{ring}<rect class="box" {_sides(box)} rx="7" {stroke} fill="{fill}" '
        f'fill-opacity=".15"/>{lines}{_bars(box)}</g>'
    )


def _kind(box: Box, line: int) -> str:
    return "" if box.label is None else ' class="answer"' if line < box.text.n_answer else ' class="count"'


def _lit(box: Box) -> str:
    return " lit" if box.is_lit else ""


def _sides(box: Box, out: float = 0) -> str:
    width, height = box.width + 2 * out, box.height + 2 * out
    return f'x="{box.left - out:.1f}" y="{box.y - out:.1f}" width="{width:.1f}" height="{height:.1f}"'


def _bars(box: Box) -> str:
    bars = "".join(
        f'<rect class="class-{bar.label % len(COLOURS)}" x="{bar.x:.1f}" y="{bar.y:.1f}" width="{bar.width:.1f}" '
        f'height="{bar.height:.1f}" fill="{_colour(bar.label)}"/>'
        for bar in box.bars
    )
    if box.mark is None:
        return bars
    x, top, bottom = box.mark
    return f'{bars}<path d="M{x:.1f} {top:.1f}V{bottom:.1f}" stroke="currentColor" stroke-width="1.5"/>'


def _colour(label: int) -> str:
    return COLOURS[label % len(COLOURS)]
