"""Where the points of a curve of objective against depth stand, in pixels; the template writes it as SVG."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

from octmip.interfaces.report.tree.evidence import DepthPoint
from octmip.interfaces.report.tree.words import compact, figure

WIDTH, HEIGHT = 340.0, 260.0
"""Narrow enough for a telephone at full size, so that no text shrinks."""
LEFT, RIGHT, TOP, BOTTOM = 58.0, 328.0, 14.0, 208.0
STEPS = (1.0, 2.0, 2.5, 5.0, 10.0)
Mark = tuple[float, float, str]


@dataclass(frozen=True, slots=True)
class Curve:
    """A curve in its places [px].

    Attributes
    ----------
    rows, columns
        (place, text) of the lines across and of the depths.
    best, greedy
        (x, y, title) of the points.
    best_path, greedy_path
        lines through them.
    open
        (x, y of the bound, y of the objective) where the gap is open.
    across
        what the horizontal axis shows.
    """

    rows: tuple[tuple[float, str], ...]
    columns: tuple[tuple[float, str], ...]
    best: tuple[Mark, ...]
    greedy: tuple[Mark, ...]
    best_path: str
    greedy_path: str
    open: tuple[tuple[float, float, float], ...]
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
    is_open = [p for p in points if not p.is_proven and math.isfinite(p.bound)]
    return Curve(
        rows=tuple((y_of(value), figure(value, 4) if value < WIDEST else compact(value, WIDEST)) for value in ticks),
        columns=tuple((x_of(p.depth), str(p.depth)) for p in points),
        best=tuple(best),
        greedy=tuple(greedy),
        best_path=_path(best),
        greedy_path=_path(greedy),
        open=tuple((x_of(p.depth), y_of(p.bound), y_of(p.objective)) for p in is_open),
    )


def _path(marks: Sequence[Mark]) -> str:
    return "M" + "L".join(f"{x:.1f} {y:.1f}" for x, y, _ in marks)


def _ticks(most: float) -> list[float]:
    """Return round values from 0 to at least `most`, five steps at most."""
    if most <= 0:
        return [0.0, 1.0]
    size = 10 ** math.floor(math.log10(most / 4))
    step = next(size * s for s in STEPS if size * s * 4 >= most)
    return [k * step for k in range(math.ceil(most / step - 1e-9) + 1)]
