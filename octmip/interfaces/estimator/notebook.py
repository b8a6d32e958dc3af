"""The picture of a fitted tree in a notebook: an SVG that carries its own style and follows the colours of the page.

The boxes are those of the report's drawing; here they are written without its template, which needs an extra.
"""

from html import escape

from octmip.interfaces.report.tree.drawing import TEXT, Box, Drawing

MOST_LEAVES = 64
"""With more leaves the picture is too wide to be read, and the tree is shown as text."""
COLOURS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#8c6d31", "#7f7f7f")
"""Of the classes, apart for colour-blind readers too. Source: Okabe & Ito (2008), and two more."""
FIRST_LINE, LINE = 22, 20
"""From the upper edge of a box to its first line of text, and between lines [px], as the drawing reckons."""
BAR = 6
"""Height of the bar that shows the classes of a leaf [px]."""


def drawing_svg(drawing: Drawing) -> str:
    """Return the drawing of a tree as an SVG element."""
    edges = "".join(_edge(box) for box in drawing.boxes)
    boxes = "".join(_box(box) for box in drawing.boxes)
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" role="img" aria-label="the fitted tree" width="{drawing.width:.0f}" '
        f'height="{drawing.height:.0f}" font-family="sans-serif" font-size="{TEXT}" text-anchor="middle" '
        f'fill="currentColor">{edges}{boxes}</svg>'
    )


def _edge(box: Box) -> str:
    edge = box.edge
    if edge is None:
        return ""
    line = f'<path d="{edge.path}" fill="none" stroke="currentColor" stroke-opacity=".5"/>'
    return f'{line}<text x="{edge.x:.1f}" y="{edge.y:.1f}" fill-opacity=".75">{escape(edge.word)}</text>'


def _box(box: Box) -> str:
    fill = "none" if box.label is None else COLOURS[box.label % len(COLOURS)]
    edge = "currentColor" if box.label is None else fill
    lines = "".join(
        f'<text x="{box.x:.1f}" y="{box.y + FIRST_LINE + LINE * k:.1f}">{escape(line)}</text>'
        for k, line in enumerate(box.lines)
    )
    bar = "".join(
        f'<rect x="{x:.1f}" y="{box.y + box.height - BAR - 7:.1f}" width="{width:.1f}" height="{BAR}" '
        f'fill="{COLOURS[label % len(COLOURS)]}"/>'
        for x, width, label in box.bar
    )
    return (
        f'<g><title>{escape(box.title)}</title><rect x="{box.x - box.width / 2:.1f}" y="{box.y:.1f}" '
        f'width="{box.width:.1f}" height="{box.height:.1f}" rx="7" stroke="{edge}" fill="{fill}" fill-opacity=".15"/>'
        f"{lines}{bar}</g>"
    )


def notebook_html(picture: str, verdict: str) -> str:
    """Return the picture in a frame that scrolls where it is wider than the cell, with the verdict below it."""
    below = f'<div style="margin-top:4px;font-family:sans-serif;font-size:13px">{escape(verdict)}</div>'
    return f'<div style="overflow-x:auto;margin-top:8px">{picture}</div>{below}'
