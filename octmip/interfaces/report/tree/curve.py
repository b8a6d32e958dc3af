"""Where the points of curves stand, in pixels: objective against depth, and ROC; the template writes them as SVG."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

from octmip.interfaces.report.tree.evidence import DepthPoint
from octmip.interfaces.report.tree.words import compact, figure
from octmip.trees.tradeoff.held_out import Ranking

WIDTH, HEIGHT = 340.0, 260.0
"""Narrow enough for a telephone at full size, so that no text shrinks."""
LEFT, RIGHT, TOP, BOTTOM = 58.0, 328.0, 14.0, 208.0
STEPS = (1.0, 2.0, 2.5, 5.0, 10.0)
MOST_LINES = 8
"""Classes that have a colour of their own."""
Mark = tuple[float, float, str]


@dataclass(frozen=True, slots=True)
class Curve:
    """A curve in its places [px].

    Attributes
    ----------
    rows, columns
        (place, text) of the lines across and of the depths.
    lines
        (style, path, title) of each.
    best, greedy
        (x, y, title) of the points.
    open
        (x, y of the bound, y of the objective) where the gap is open.
    across
        what the horizontal axis shows.
    """

    rows: tuple[tuple[float, str], ...]
    columns: tuple[tuple[float, str], ...]
    lines: tuple[tuple[str, str, str], ...]
    best: tuple[Mark, ...] = ()
    greedy: tuple[Mark, ...] = ()
    open: tuple[tuple[float, float, float], ...] = ()
    across: str = "depth of the tree"
    width: float = WIDTH
    height: float = HEIGHT
    left: float = LEFT
    right: float = RIGHT
    bottom: float = BOTTOM


WIDEST = 1e6
"""Numbers on the axis from which on a power of ten is shorter."""


def depth_curve(points: Sequence[DepthPoint], what: str) -> Curve:
    """Return the curve of at least one depth; `what` is what the vertical axis counts."""
    most = max(max(point.objective, point.greedy_objective or 0.0) for point in points)
    ticks = _ticks(most)

    def x_of(depth: int) -> float:
        return LEFT + 18 + (RIGHT - LEFT - 36) * (k_of[depth] / max(1, len(points) - 1) if len(points) > 1 else 0.5)

    def y_of(value: float) -> float:
        return BOTTOM - (BOTTOM - TOP) * max(0.0, value) / ticks[-1]

    k_of = {point.depth: k for k, point in enumerate(points)}
    best = [(x_of(p.depth), y_of(p.objective), f"depth {p.depth}: {what} {figure(p.objective)}") for p in points]
    greedy = [
        (x_of(p.depth), y_of(p.greedy_objective), f"depth {p.depth}, greedy: {what} {figure(p.greedy_objective)}")
        for p in points
        if p.greedy_objective is not None
    ]
    drawn = (("greedy", greedy), ("best", best))
    is_open = [p for p in points if not p.is_proven and math.isfinite(p.bound)]
    return Curve(
        rows=tuple((y_of(value), figure(value, 4) if value < WIDEST else compact(value, WIDEST)) for value in ticks),
        columns=tuple((x_of(p.depth), str(p.depth)) for p in points),
        lines=tuple((style, _path([mark[:2] for mark in marks]), "") for style, marks in drawn),
        best=tuple(best),
        greedy=tuple(greedy),
        open=tuple((x_of(p.depth), y_of(p.bound), y_of(p.objective)) for p in is_open),
    )


def roc_curve(ranking: Ranking, names: Sequence[str]) -> Curve | None:
    """Return the ROC of each class that has one; None where there is none, or the classes have no colours apart."""
    areas = ranking.auroc.tolist() if len(names) <= MOST_LINES else []
    known = [k for k, area in enumerate(areas) if math.isfinite(area)]

    def x_of(rate: float) -> float:
        return LEFT + (RIGHT - LEFT) * rate

    def y_of(rate: float) -> float:
        return BOTTOM - (BOTTOM - TOP) * rate

    if not known:
        return None
    lines = [("grid", _path([(LEFT, BOTTOM), (RIGHT, TOP)]), "a guess")]
    for k in known:
        path = _path([(x_of(x), y_of(y)) for x, y in ranking.roc(k).T.tolist()])
        lines.append((f"class-{k}", path, f"{names[k]}: AUROC {figure(areas[k], 3)}"))
    rates = (0.0, 0.25, 0.5, 0.75, 1.0)
    return Curve(
        rows=tuple((y_of(rate), figure(rate)) for rate in rates),
        columns=tuple((x_of(rate), figure(rate)) for rate in rates),
        lines=tuple(lines),
        across="right: false positives; up: true positives",
    )


def _path(places: Sequence[tuple[float, float]]) -> str:
    return "M" + "L".join(f"{x:.1f} {y:.1f}" for x, y in places)


def _ticks(most: float) -> list[float]:
    """Return round values from 0 to at least `most`, five steps at most."""
    if most <= 0:
        return [0.0, 1.0]
    size = 10 ** math.floor(math.log10(most / 4))
    step = next(size * s for s in STEPS if size * s * 4 >= most)
    return [k * step for k in range(math.ceil(most / step - 1e-9) + 1)]
