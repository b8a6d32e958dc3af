"""Figures of the diagnosis page as inline SVG: they stand side by side at their own size or larger, never smaller."""

from collections.abc import Sequence
from dataclasses import dataclass
from math import floor, log10

import numpy as np
from numpy.typing import NDArray

from octmip.input.names import html_text as escape
from octmip.input.names import shown
from octmip.interfaces.report.diagnosis.measured import MeasuredCell
from octmip.interfaces.report.diagnosis.phrases import amount, digits_of, with_unit
from octmip.twin import MICROSTRAIN, MIXED, amounts_of

Floats = NDArray[np.float64]

PANEL, ROW, LABEL = 264, 18, 66
"""Width of a panel, height of a gauge's row and width of its name [px]."""
SMALL, TALL = 168, 150
"""Width and height of a gauge's own panel [px]."""
DASH = 8
"""Half of the length of a line over one load [px]."""
MAP, DOT = 560, 8
"""Width of the map and radius of a gauge on it, in its own units: shown at 340 to 560 px."""
UNIT_SHORT = {MIXED: "noise sd"}
"""Units that are too long for an axis."""
LONGEST = 9
"""Letters of a gauge's name in a figure."""


@dataclass(frozen=True, slots=True)
class Scale:
    """A linear scale from values to pixels."""

    low: float
    high: float
    start: float
    end: float

    def __call__(self, value: float) -> float:
        """Return the pixel of a value."""
        return self.start + (value - self.low) / ((self.high - self.low) or 1.0) * (self.end - self.start)


def short(name: str) -> str:
    """Return a name that fits beside a row."""
    text = shown(name)
    return text if len(text) <= LONGEST else text[: LONGEST - 1] + "…"


def nice_limit(value: float) -> float:
    """Return a round number not below a value: one or two digits."""
    if not value > 0.0:
        return 1.0
    power = 10.0 ** floor(log10(value))
    return next(
        step * power for step in (1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 6.0, 8.0, 10.0) if step * power >= value * 0.999
    )


def largest_difference(cells: Sequence[MeasuredCell]) -> float:
    """Return a round limit that all differences of these cells keep, their error bars included, as they are drawn."""
    reach = [
        np.nanmax(np.abs(part) + cell.half_width / cell.scale, initial=0.0) for cell in cells for part in _drawn(cell)
    ]
    return nice_limit(float(max(reach, default=1.0)))


def _drawn(cell: MeasuredCell) -> tuple[Floats, Floats]:
    """Return the differences before and after as they are drawn side by side, 0 where nothing was recorded."""
    return np.nan_to_num(cell.before / cell.scale), np.nan_to_num(cell.after / cell.scale)


def load_panel(cell: MeasuredCell, gauges: Sequence[str], limit: float, title: str, has_repair: bool) -> str:
    """Return one test at one load: measured less predicted at every gauge, a row each, before and after."""
    height = ROW * len(gauges) + 46
    x = Scale(-limit, limit, LABEL, PANEL - 12)
    bottom = ROW * len(gauges) + 8
    parts = [_open(PANEL, height, title, _panel_words(cell, gauges, has_repair))]
    parts += [_vertical(x(tick), 4, bottom, "zero" if tick == 0 else "grid") for tick in (-limit, 0.0, limit)]
    parts += [_row(cell, k, name, x, has_repair) for k, name in enumerate(gauges)]
    for tick, anchor in ((-limit, "start"), (0.0, "middle"), (limit, "end")):
        parts.append(_text(x(tick), bottom + 15, f"{tick:+g}" if tick else "0", anchor))
    parts.append(
        _text(PANEL / 2, bottom + 31, f"measured less predicted [{UNIT_SHORT.get(cell.unit, cell.unit)}]", "middle")
    )
    return "".join([*parts, "</svg>"])


def _panel_words(cell: MeasuredCell, gauges: Sequence[str], has_repair: bool) -> str:
    before, after = (float(np.nanmax(np.abs(part), initial=0.0)) for part in _drawn(cell))
    far = gauges[int(np.argmax(np.abs(_drawn(cell)[0])))]
    words = f"Largest difference {amount(before, cell.unit)}, at gauge {shown(far)}"
    return f"{words}; {amount(after, cell.unit)} with the effect added." if has_repair else f"{words}."


def _row(cell: MeasuredCell, k: int, name: str, x: Scale, has_repair: bool) -> str:
    y = 4 + ROW * (k + 0.5)
    label = _text(LABEL - 8, y + 4, short(name), "end", "name")
    if np.isnan(cell.measured[k]):
        return f"<g>{label}{_text(x(0.0) + 6, y + 4, 'not recorded', 'start')}</g>"
    scale = float(cell.scale[k])
    usual = x(cell.usual[k] / scale) - x(0.0)
    parts = [f'<rect class="usual" x="{x(0.0) - usual:.1f}" y="{y - 7:.1f}" width="{2 * usual:.1f}" height="14"/>']
    shift, half = 3.5 if has_repair else 0.0, float(cell.half_width[k]) / scale
    parts.append(_whisker(x, float(cell.before[k]) / scale, half, y - shift, "before"))
    if has_repair:
        parts.append(_whisker(x, float(cell.after[k]) / scale, half, y + shift, "after"))
    return f"<g><title>{escape(_row_words(cell, k, name, has_repair))}</title>{label}{''.join(parts)}</g>"


def _row_words(cell: MeasuredCell, k: int, name: str, has_repair: bool) -> str:
    unit, own = cell.units[k], (cell.measured, cell.half_width, cell.twin, cell.repaired)
    measured, half, twin, repaired = (digits_of(float(values[k]), unit) for values in own)
    words = f"{shown(name)}: measured {measured} ± {half}, twin {twin}"
    return with_unit(f"{words}, with the effect {repaired}" if has_repair else words, unit)


def _whisker(x: Scale, value: float, half: float, y: float, kind: str) -> str:
    line = f'<line x1="{x(value - half):.1f}" x2="{x(value + half):.1f}" y1="{y:.1f}" y2="{y:.1f}" class="{kind}"/>'
    return f'{line}<circle cx="{x(value):.1f}" cy="{y:.1f}" r="3.2" class="{kind}"/>'


def gauge_panel(cells: Sequence[MeasuredCell], gauge: int, name: str, has_repair: bool) -> str:
    """Return one gauge: its readings over the load, measured with error bars, predicted before and after."""
    seen, at = [cell for cell in cells if not np.isnan(cell.measured[gauge])], _abscissae(cells)
    loads = sorted({at[id(cell)] for cell in cells})
    values = [float(v) for cell in seen for v in (cell.measured[gauge], cell.twin[gauge], cell.repaired[gauge])] or [
        0.0
    ]
    low, high = min(0.0, *values), max(0.0, *values)
    x, y = Scale(loads[0], loads[-1], 44, SMALL - 16), Scale(low, high or 1.0, TALL - 36, 30)
    kinds = ("before", "after") if has_repair else ("before",)
    worst, unit = max((abs(float(cell.before[gauge])) for cell in seen), default=0.0), cells[0].units[gauge]
    parts = [_open(SMALL, TALL, f"Gauge {shown(name)} over the load", f"Largest difference {amount(worst, unit)}.")]
    parts += [_text(44, 16, short(name), "start", "name"), _vertical(44, 30, TALL - 36, "grid")]
    parts += [
        _text(40, y(v) + 4, f"{v:.0f}" if unit == MICROSTRAIN else f"{v:.3g}", "end")
        for v in ((low, high) if high > low else (low,))
    ]
    parts.append(f'<line x1="44" x2="{SMALL - 8}" y1="{y(0.0):.1f}" y2="{y(0.0):.1f}" class="grid"/>')
    parts += [_text(x(load), TALL - 20, f"{load:g}", "middle") for load in _few(loads)]
    parts.append(_text((44 + SMALL - 16) / 2, TALL - 4, axis_words(cells), "middle"))
    parts += [_course(seen, at, gauge, x, y, kind) for kind in kinds]
    parts += [_measured_dot(cell, at[id(cell)], gauge, x, y) for cell in seen]
    return "".join([*parts, "</svg>"])


def _abscissae(cells: Sequence[MeasuredCell]) -> dict[int, float]:
    """Return where each cell stands along the axis: at its one load, or of several at the number of its load."""
    loads = sorted({cell.load for cell in cells}, key=amounts_of)
    has_one = len(amounts_of(loads[0])) == 1
    return {id(cell): amounts_of(cell.load)[0] if has_one else loads.index(cell.load) + 1.0 for cell in cells}


def axis_words(cells: Sequence[MeasuredCell]) -> str:
    """Return the name of the axis of loads: the one load, or the number of the load in the order of the table."""
    has_one = len(amounts_of(cells[0].load)) == 1
    return cells[0].load_words.rpartition(" ")[0] if has_one else "number of the load"


def _few(loads: Sequence[float]) -> Sequence[float]:
    return loads if len(loads) <= 4 else (loads[0], loads[len(loads) // 2], loads[-1])


def _course(cells: Sequence[MeasuredCell], at: dict[int, float], gauge: int, x: Scale, y: Scale, kind: str) -> str:
    """Return what is predicted over the load, a line for each test; tests of one load and one state share theirs.

    Where a line would be one point it is a dash.
    """
    loads: dict[str, set[float]] = {}
    for cell in cells:
        loads.setdefault(cell.test, set()).add(at[id(cell)])
    courses: dict[object, list[tuple[float, float]]] = {}
    for cell in cells:
        predicted = cell.twin[gauge] if kind == "before" else cell.repaired[gauge]
        course = courses.setdefault(cell.test if len(loads[cell.test]) > 1 else cell.state, [])
        course.append((x(at[id(cell)]), y(float(predicted))))
    lines = []
    for course in courses.values():
        places = sorted(course)
        if places[0][0] == places[-1][0]:
            places = [(places[0][0] - DASH, places[0][1]), (places[-1][0] + DASH, places[-1][1])]
        points = " ".join(f"{across:.1f},{up:.1f}" for across, up in places)
        lines.append(f'<polyline points="{points}" class="{kind}"/>')
    return "".join(lines)


def _measured_dot(cell: MeasuredCell, load: float, gauge: int, x: Scale, y: Scale) -> str:
    at, value, half = x(load), float(cell.measured[gauge]), float(cell.half_width[gauge])
    where = f"{cell.test}, {cell.load_words}" if cell.load_words else cell.test
    unit = cell.units[gauge]
    words = f"{where}: {digits_of(value, unit)} ± {amount(half, unit)}"
    bar = f'<line x1="{at:.1f}" x2="{at:.1f}" y1="{y(value - half):.1f}" y2="{y(value + half):.1f}" class="measured"/>'
    return (
        f'<g><title>{escape(words)}</title>{bar}<circle cx="{at:.1f}" cy="{y(value):.1f}" r="3" class="measured"/></g>'
    )


def gauge_map(
    points: Floats,
    values: Floats,
    names: Sequence[str],
    limit: float,
    outline: Floats | None,
    title: str,
    unit: str = MICROSTRAIN,
    ringed: Sequence[str] = (),
) -> str:
    """Return gauges (x aft, y outboard) as dots on the outline, y to the right; the farthest off are named.

    A ring stands around those that the diagnosis names.

    Chords are drawn larger than spans, so that neighbouring rows of gauges stay apart.
    """
    corners = points if outline is None else np.concatenate([points, np.asarray(outline)[:, :2]])
    low, high = corners.min(axis=0), corners.max(axis=0)
    across, along = (max(float(extent), 1e-9) for extent in high - low)
    depth = 200.0 if float(high[0] - low[0]) > 0.0 else 0.0
    scale = np.array([depth / across, (MAP - 80.0) / along])

    def place(point: Floats) -> tuple[float, float]:
        x, y = scale * (point - low)
        return 40.0 + float(y), 40.0 + float(x)

    farthest = float(np.nanmax(np.abs(values), initial=0.0))
    worst = f"The farthest off is {amount(farthest, unit)} from the twin."
    height = depth + 80.0
    parts = [f'<svg viewBox="0 0 {MAP} {height:.0f}" class="map" role="img">{_titled(title, worst)}']
    if outline is not None:
        path = " ".join(f"{x:.1f},{y:.1f}" for x, y in map(place, np.asarray(outline)[:, :2]))
        parts.append(f'<polygon points="{path}" class="outline"/>')
    parts += [_dot(*place(p), float(v), name, limit, unit) for p, v, name in zip(points, values, names, strict=True)]
    rings = [place(p) for p, name in zip(points, names, strict=True) if name in ringed]
    parts += [f'<circle cx="{x:.1f}" cy="{y:.1f}" r="{DOT + 6}" class="ring"/>' for x, y in rings]
    order = np.argsort(-np.abs(np.nan_to_num(values)), kind="stable")[:3]
    for k in (int(k) for k in order if abs(np.nan_to_num(values[k])) > 0.25 * limit):
        x, y = place(points[k])
        anchor = "start" if x < 60 else "end" if x > MAP - 60 else "middle"
        parts.append(
            f'<text x="{x:.1f}" y="{y - 13:.1f}" class="big" text-anchor="{anchor}">{escape(short(names[k]))}</text>'
        )
    return "".join([*parts, "</svg>"])


def _dot(x: float, y: float, value: float, name: str, limit: float, unit: str) -> str:
    words = "no reading" if np.isnan(value) else amount(value, unit, "+")
    fill = "var(--line)" if np.isnan(value) else mixed(value / limit)
    return (
        f'<circle cx="{x:.1f}" cy="{y:.1f}" r="{DOT}" style="fill:{fill}" class="gauge">'
        f"<title>{escape(shown(name))}: {words}</title></circle>"
    )


def mixed(share: float) -> str:
    """Return the ground's colour at 0, the hot one at 1, the cold one at -1."""
    part = 100.0 * min(1.0, abs(share))
    return f"color-mix(in srgb, var({'--hot' if share > 0 else '--cold'}) {part:.0f}%, var(--paper))"


def _open(width: int, height: float, title: str, words: str) -> str:
    size = f'width="{width}" height="{height:.0f}" viewBox="0 0 {width} {height:.0f}"'
    return f'<svg {size} role="img">{_titled(title, words)}'


def _titled(title: str, words: str) -> str:
    return f"<title>{escape(title)}</title><desc>{escape(words)}</desc>"


def _text(x: float, y: float, words: str, anchor: str, kind: str = "quiet") -> str:
    return f'<text x="{x:.1f}" y="{y:.1f}" text-anchor="{anchor}" class="{kind}">{escape(words)}</text>'


def _vertical(x: float, top: float, bottom: float, kind: str) -> str:
    return f'<line x1="{x:.1f}" x2="{x:.1f}" y1="{top:.1f}" y2="{bottom:.1f}" class="{kind}"/>'
