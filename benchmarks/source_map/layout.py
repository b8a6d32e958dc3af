"""Layout: where the boxes of a layered drawing lie, and through which points its arrows pass.

An arrow over several rows passes each row between at a bend, which is laid out as a narrow box. Order within the rows
and positions follow from the mean position of the neighbours. Source: Sugiyama, Tagawa & Toda (1981), Methods for
visual understanding of hierarchical system structures.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import pairwise

from benchmarks.source_map.arrows import Arrows

WIDTH, MARGIN, GAP = 1180, 46, 8
BOX, ROW, LETTER = 24, 62, 7.0  # heights of a box and a row, width of a letter [px]
BEND = 6  # width of a bend [px]
SWEEPS = 40  # of ordering, and of positioning; more change nothing

Point = str | tuple[str, str, int]  # a box by its name, or the bend of an arrow (from, to) in a row
Place = tuple[float, float, float]  # left, top, width [px]


@dataclass(slots=True)
class Layout:
    """The rows of a drawing from the top, each in order, and the points that each arrow passes."""

    rows: list[list[Point]]
    routes: list[list[Point]]

    @classmethod
    def of(cls, levels: Mapping[str, int], arrows: Arrows) -> "Layout":
        """Return a layout of boxes by level and of the arrows between them, few of which cross."""
        steps = sorted(set(levels.values()), reverse=True)
        rows: list[list[Point]] = [[part for part in levels if levels[part] == step] for step in steps]
        routes: list[list[Point]] = []
        for part in levels:
            for other in sorted(arrows[part]):
                between = range(steps.index(levels[part]) + 1, steps.index(levels[other]))
                bends: list[Point] = [(part, other, row) for row in between]
                for row, bend in zip(between, bends, strict=True):
                    rows[row].append(bend)
                routes.append([part, *bends, other])
        layout = cls(rows, routes)
        layout._order()
        return layout

    def _neighbours(self) -> dict[Point, list[Point]]:
        near: dict[Point, list[Point]] = {point: [] for row in self.rows for point in row}
        for route in self.routes:
            for upper, lower in pairwise(route):
                near[upper].append(lower)
                near[lower].append(upper)
        return near

    def _order(self) -> None:
        near = self._neighbours()
        at = {point: (k + 0.5) / len(row) for row in self.rows for k, point in enumerate(row)}
        for sweep in range(SWEEPS):
            for row in self.rows if sweep % 2 else reversed(self.rows):
                mean = {point: sum(at[o] for o in near[point]) / len(near[point]) for point in row if near[point]}
                row.sort(key=lambda point: (mean.get(point, at[point]), str(point)))
                at.update({point: (k + 0.5) / len(row) for k, point in enumerate(row)})

    def places(self, top: float) -> dict[Point, Place]:
        """Return where every box and bend lies, the first row at `top` [px]."""
        near, widths = self._neighbours(), {point: _width(point) for row in self.rows for point in row}
        middle = {point: x for row in self.rows for point, x in _spread(row, dict.fromkeys(row, WIDTH / 2), widths)}
        for _ in range(SWEEPS):
            for row in self.rows:
                wanted = {p: sum(middle[o] for o in near[p]) / max(len(near[p]), 1) or middle[p] for p in row}
                middle.update(_spread(row, wanted, widths))
        shift = (WIDTH + MARGIN - min(middle.values()) - max(middle.values())) / 2
        return {
            point: (middle[point] + shift - widths[point] / 2, top + ROW * k, widths[point])
            for k, row in enumerate(self.rows)
            for point in row
        }


def _width(point: Point) -> float:
    return len(point) * LETTER + 18 if isinstance(point, str) else BEND


def _spread(row: list[Point], wanted: dict[Point, float], widths: dict[Point, float]) -> list[tuple[Point, float]]:
    """Return positions in the given order, apart from each other and near the wanted ones."""
    left = []
    edge = float(MARGIN)
    for point in row:
        edge = max(edge, wanted[point] - widths[point] / 2)
        left.append(edge + widths[point] / 2)
        edge += widths[point] + GAP
    right = []
    edge = float(WIDTH - GAP)
    for point in reversed(row):
        edge = min(edge, wanted[point] + widths[point] / 2)
        right.append(edge - widths[point] / 2)
        edge -= widths[point] + GAP
    return [(point, (a + b) / 2) for point, a, b in zip(row, left, reversed(right), strict=True)]
