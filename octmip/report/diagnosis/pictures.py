"""Figures of the report as inline SVG."""

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from octmip.formats.names import html_text as escape

Floats = NDArray[np.float64]

WIDTH = 860
ROW = 26
LABEL = 300
MARGIN = 40
MAP_WIDTH = 1200
MAP_DEPTH = 420.0
DOT = 14


def bars(
    labels: Sequence[str],
    values: Sequence[float],
    full: float,
    words: Callable[[float], str],
    colours: Sequence[str] = ("#2f6db3",),
) -> str:
    """Return horizontal bars, each with its label and its value in words, the colours in turn."""
    height = ROW * len(labels) + 8
    parts = [f'<svg viewBox="0 0 {WIDTH} {height}" role="img" font-family="system-ui,sans-serif" font-size="13">']
    for k, (label, value) in enumerate(zip(labels, values, strict=True)):
        y = ROW * k + 4
        length = (WIDTH - LABEL - 150) * min(1.0, max(0.0, value / full))
        shown = label if len(label) <= 42 else label[:41] + "…"
        parts.append(f'<text x="{LABEL - 8}" y="{y + 15}" text-anchor="end">{escape(shown)}</text>')
        parts.append(
            f'<rect x="{LABEL}" y="{y + 2}" width="{length:.1f}" height="{ROW - 9}" '
            f'fill="{colours[k % len(colours)]}"/>'
        )
        parts.append(f'<text x="{LABEL + length + 6:.1f}" y="{y + 15}" fill="#57606a">{escape(words(value))}</text>')
    return "".join([*parts, "</svg>"])


def gauge_map(points: Floats, values: Floats, names: Sequence[str], limit: float, outline: Floats | None) -> str:
    """Return gauges (x aft, y outboard) as named dots on the outline, y to the right, red above and blue below zero.

    Chords are drawn larger than spans, so that neighbouring rows of gauges stay apart.
    """
    corners = points if outline is None else np.concatenate([points, np.asarray(outline)[:, :2]])
    low, high = corners.min(axis=0), corners.max(axis=0)
    across, along = (max(float(extent), 1e-9) for extent in high - low)
    depth = MAP_DEPTH if float(high[0] - low[0]) > 0.0 else 0.0
    scale = np.array([depth / across, (MAP_WIDTH - 2 * MARGIN) / along])

    def place(point: Floats) -> tuple[float, float]:
        x, y = scale * (point - low)
        return MARGIN + float(y), MARGIN + float(x)

    box = f"0 0 {MAP_WIDTH} {depth + 2 * MARGIN:.0f}"
    parts = [f'<svg viewBox="{box}" role="img" font-family="system-ui,sans-serif" text-anchor="middle">']
    if outline is not None:
        path = " ".join(f"{x:.1f},{y:.1f}" for x, y in map(place, np.asarray(outline)[:, :2]))
        parts.append(f'<polygon points="{path}" fill="#f3f6fa" stroke="#8c959f"/>')
    parts += [
        _dot(*place(point), float(value), name, limit) for point, value, name in zip(points, values, names, strict=True)
    ]
    return "".join([*parts, "</svg>"])


def _dot(x: float, y: float, value: float, name: str, limit: float) -> str:
    tooltip = "no reading" if np.isnan(value) else f"{value:+.1f} microstrain"
    shown = "" if np.isnan(value) else f"{value:+.0f}"
    ink = "#fff" if abs(value) > 0.6 * limit else "#1b1f24"
    return (
        f'<circle cx="{x:.1f}" cy="{y:.1f}" r="{DOT}" fill="{colour(value, limit)}" stroke="#1b1f24">'
        f"<title>{escape(name)}: {tooltip}</title></circle>"
        f'<text x="{x:.1f}" y="{y + 3:.1f}" font-size="10" fill="{ink}">{escape(name)}</text>'
        f'<text x="{x:.1f}" y="{y + DOT + 12:.1f}" font-size="11" fill="#57606a">{shown}</text>'
    )


def colour(value: float, limit: float) -> str:
    """Return white at 0, red at `limit`, blue at minus `limit`, grey where there is no value."""
    if np.isnan(value):
        return "#c0c0c0"
    share = float(np.clip(value / limit, -1.0, 1.0))
    end = (179, 38, 30) if share > 0 else (33, 94, 173)
    red, green, blue = (round(255 + abs(share) * (e - 255)) for e in end)
    return f"#{red:02x}{green:02x}{blue:02x}"
