"""The map of docs/developing.md, drawn from the sources: `python -m benchmarks.source_map.draw`.

A box is a line of the table of levels, a row is a level. An arrow says that a part uses another; arrows that follow
from others (a uses b, b uses c, so a may use c) are left out.
"""

from collections.abc import Mapping
from html import escape
from itertools import pairwise
from pathlib import Path

from benchmarks.small_svg import small
from benchmarks.source_map.arrows import ROOT, Arrows, python_arrows, rust_arrows
from benchmarks.source_map.layout import BEND, BOX, ROW, WIDTH, Layout, Place
from benchmarks.source_map.levels import LEVELS, part_of

PICTURE = ROOT / "docs" / "pictures" / "map.svg"
TITLES = {
    "octmip": "octmip: problems, trees, proofs, the twin at work",
    "native": "the native core: crates of Rust, the border to Python above, the checker of proof logs at the bottom",
    "femlib": "femlib: the wing",
}

STYLE = """
text { font: 12px ui-monospace, Menlo, Consolas, monospace; fill: #1b1f24 }
text.title { font: 600 14px system-ui, sans-serif } text.level { fill: #6e7781 }
rect.page { fill: #ffffff } rect.box { fill: #eef2f6; stroke: #8c959f }
path { fill: none; stroke: #8c959f; stroke-width: 1 }
@media (prefers-color-scheme: dark) {
  text { fill: #e6edf3 } rect.page { fill: #0d1117 } rect.box { fill: #21262d; stroke: #6e7681 }
  path { stroke: #6e7681 }
}
"""


def parts_arrows(package: str, arrows: Arrows) -> Arrows:
    """Return which lines of the table of a package use which, from the arrows between files."""
    found: dict[str, set[str]] = {part: set() for part in LEVELS[package]}
    for name, used in arrows.items():
        user = _line(package, name)
        if user in found:
            found[user] |= {_line(package, other) for other in used} & set(found) - {user}
    return {part: frozenset(others) for part, others in found.items()}


def without_detours(arrows: Arrows) -> Arrows:
    """Return the arrows that do not follow from others; there is no circle among them."""
    below: dict[str, frozenset[str]] = {}

    def reach(part: str) -> frozenset[str]:
        if part not in below:
            below[part] = arrows[part].union(*(reach(other) for other in arrows[part]))
        return below[part]

    return {part: frozenset(o for o in used if not any(o in reach(b) for b in used)) for part, used in arrows.items()}


def svg() -> str:
    """Return the map as SVG, the same text for the same sources."""
    python, rust = python_arrows(("octmip", "femlib")), rust_arrows()
    blocks, top = [], 10.0
    for package, title in TITLES.items():
        arrows = without_detours(parts_arrows(package, rust if package == "native" else python))
        block, height = _block(LEVELS[package], arrows, title, top)
        blocks.append(block)
        top += height
    head = f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {top:.0f}" role="img">'
    page = f'<rect class="page" width="{WIDTH}" height="{top:.0f}"/>'
    tip = '<marker id="tip" viewBox="0 0 8 8" refX="8" refY="4" markerWidth="7" markerHeight="7" orient="auto">'
    tip += '<path d="M 0 0 L 8 4 L 0 8"/></marker>'
    return small("\n".join([head, f"<style>{STYLE}</style>", f"<defs>{tip}</defs>", page, *blocks, "</svg>"]))


def _line(package: str, name: str) -> str:
    """Return the line of a package's table that a file belongs to, "" for one of another package."""
    top, _, inside = name.partition(".")
    if package == "native":
        return top
    return part_of(package, inside) if top == package else ""


def _block(levels: Mapping[str, int], arrows: Arrows, title: str, top: float) -> tuple[str, float]:
    """Return the drawing of one package whose first line lies at `top`, and its height [px]."""
    layout = Layout.of(levels, arrows)
    at = layout.places(top + 34)
    lines = [f'<text class="title" x="14" y="{top + 18:.0f}">{escape(title)}</text>']
    for row, level in zip(layout.rows, sorted(set(levels.values()), reverse=True), strict=True):
        lines.append(f'<text class="level" x="14" y="{at[row[0]][1] + 16:.0f}">{level}</text>')
    lines += [_arrow([at[point] for point in route]) for route in layout.routes]
    lines += [_box(part, place) for part, place in at.items() if isinstance(part, str)]
    return "\n".join(lines), 34 + ROW * len(layout.rows) + 10


def _arrow(route: list[Place]) -> str:
    """Return a line from the first box down through the places between to the last box."""
    curve = ""
    for (x, y, width), (to_x, to_y, to_width) in pairwise(route):
        x, y, to_x, to_y = x + width / 2, y + BOX, to_x + to_width / 2, to_y - (to_width > BEND)
        middle = (y + to_y) / 2
        curve += "" if curve else f"M {x:.0f} {y:.0f}"
        curve += f" C {x:.0f} {middle:.0f} {to_x:.0f} {middle:.0f} {to_x:.0f} {to_y:.0f}"
        curve += f" V {to_y + BOX:.0f}" if to_width <= BEND else ""
    return f'<path d="{curve}" marker-end="url(#tip)"/>'


def _box(part: str, place: Place) -> str:
    left, top, width = place
    rect = f'<rect class="box" x="{left:.0f}" y="{top:.0f}" width="{width:.0f}" height="{BOX}" rx="4"/>'
    text = f'<text x="{left + width / 2:.0f}" y="{top + 16:.0f}" text-anchor="middle">{escape(part)}</text>'
    return rect + text


def main(picture: Path = PICTURE) -> None:
    """Write the map."""
    picture.write_text(svg(), encoding="utf-8")
    print(f"wrote {picture.relative_to(ROOT)}")


if __name__ == "__main__":
    main()
