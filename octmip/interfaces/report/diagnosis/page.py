"""The diagnosis as a page: what to do first, then the figures that say why, then the matter for those who check."""

import math
from typing import Any

import numpy as np
from markupsafe import Markup
from numpy.typing import NDArray

from octmip.gap.campaign.campaign import Campaign
from octmip.gap.causes import Cause
from octmip.gap.diagnosis import Diagnosis
from octmip.gap.inference.inputs import Inputs
from octmip.input.names import shown
from octmip.interfaces.report.diagnosis.measured import MeasuredCell, has_repair, measured_cells
from octmip.interfaces.report.diagnosis.phrases import (
    about,
    amount,
    cause_words,
    closed_words,
    digits_of,
    interval_words,
    likely,
    percent,
    size_of,
    units_words,
)
from octmip.interfaces.report.diagnosis.pictures import (
    axis_words,
    gauge_map,
    gauge_panel,
    largest_difference,
    load_panel,
)
from octmip.interfaces.report.diagnosis.recommendation import Verdict, recommend, verdict_of
from octmip.interfaces.report.diagnosis.words import (
    NO_SUCH_TEST,
    constant_lines,
    detectable_sizes,
    doubt_lines,
    explained,
    fit_lines,
    flipping_nodes,
    gap_line,
    named_gauges,
    node_name,
    noise_lines,
    page_of_words,
    place_lines,
    shown_causes,
    state_lines,
)
from octmip.interfaces.report.page import Masthead, page_facts, render
from octmip.twin import MICROSTRAIN, MIXED, Load, amounts_of, sign_of

Floats = NDArray[np.float64]

FIRST_LOADS, FIRST_GAUGES = 8, 6
"""Panels that stand open; the others are folded."""
MOST_VALUES = 12
"""Values of one load that the line under the title lists."""
NUMBERS = ("Gauge", "Test", "Load", "Measured", "90 % ±", "Twin")


def report_page(
    diagnosis: Diagnosis,
    *,
    data: str = "",
    sha256: str = "",
    commissioning: str = "",
    twin: str = "",
    masthead: Masthead | None = None,
) -> str:
    """Return the page of a diagnosis.

    Parameters
    ----------
    diagnosis
        what was found.
    data, sha256
        name of the campaign's file and digest of it.
    commissioning
        name of the commissioning run's file.
    twin
        what the twin is called.
    masthead
        heading, asset and day of the page.
    """
    more = {name: shown(value) for name, value in (("Twin", twin), ("Commissioning_run", commissioning)) if value}
    return render(
        "diagnosis.html",
        masthead=masthead,
        styles=("diagnosis.css",),
        facts=page_facts(data or None, sha256 or None, masthead.made if masthead else None, **more),
        subtitle=_subtitle(diagnosis, data, twin),
        sentence=recommend(diagnosis),
        figures=_figures(diagnosis),
        **_measured(diagnosis),
        **_where(diagnosis),
        **_which(diagnosis),
        **_how_far(diagnosis),
        **_next(diagnosis),
        notes=list(diagnosis.notes),
        checks=[
            *fit_lines(diagnosis),
            *noise_lines(diagnosis),
            *(f"State of {line}." for line in state_lines(diagnosis)),
            *(f"Constant {line}" for line in constant_lines(diagnosis)),
        ],
        words=page_of_words(diagnosis),
    )


def _subtitle(diagnosis: Diagnosis, data: str, twin: str) -> str:
    campaign = diagnosis.posterior.model.inputs.campaign
    of = f" of {shown(data)}" if data else ""
    with_ = f", against the twin {shown(twin)}" if twin else ""
    return f"{len(campaign.test):,} readings{of} at {len(campaign.gauges)} gauges{_loads(campaign)}{with_}"


def _loads(campaign: Campaign) -> str:
    """Return the loads that were applied: each name with its values."""
    applied = [sorted(set(column.tolist())) for column in campaign.applied.T]
    pairs = zip(campaign.load_names, applied, strict=True)
    named = [f"{shown(name.replace('_', ' '))}{'s' * (len(v) > 1)} {_values(v)}" for name, v in pairs]
    return "".join(f", {words}" for words in named)


def _values(values: list[float]) -> str:
    some = values if len(values) <= MOST_VALUES else [*values[: MOST_VALUES - 2], values[-1]]
    texts = [f"{value:g}" for value in some]
    return ", ".join(texts if len(values) <= MOST_VALUES else [*texts[:-1], "...", texts[-1]])


def _figures(diagnosis: Diagnosis) -> list[tuple[str, ...]]:
    """Return the key figures: sizes, probability, gap and next test."""
    first, kind = diagnosis.which[0], verdict_of(diagnosis)
    entries: list[tuple[str, ...]] = []
    if kind in (Verdict.CAUSE, Verdict.AMBIGUOUS, Verdict.HIDDEN):
        sized = [p for p in first.parameters if p.named.has_size]
        entries += [(_capital(p.named.name), size_of(p), interval_words(p)) for p in sized]
    chance = first.probability if kind is not Verdict.UNEXPLAINED else diagnosis.unknown_probability
    of = {Verdict.UNEXPLAINED: "that the library lacks the cause"}
    of |= dict.fromkeys((Verdict.SOUND, Verdict.UNMEASURED), "that nothing acts")
    tone = {Verdict.UNEXPLAINED: "warn", Verdict.UNMEASURED: "warn", Verdict.SOUND: "good"}.get(kind, "")
    entries.append(("Probability", about(chance), of.get(kind, "of the first cause"), tone))
    s = diagnosis.shrinkage
    if s is not None and s.held_out:
        closes = f"{digits_of(s.before, s.unit)} → {digits_of(s.after, s.unit)}"
        entries.append(("Gap before → after", closes, f"{s.unit}, on readings to which nothing was fitted"))
    else:
        where = diagnosis.where
        gap = digits_of(where.rms, where.unit)
        entries.append(("Gap", gap, f"{where.unit}, root mean square beyond noise"))
    return entries


def _capital(words: str) -> str:
    return words[:1].upper() + words[1:]


def _measured(diagnosis: Diagnosis) -> dict[str, Any]:
    """Return the panels by load and by gauge, and the numbers behind them."""
    cells, gauges = measured_cells(diagnosis), diagnosis.posterior.model.inputs.campaign.gauges
    repaired, limit = has_repair(diagnosis), largest_difference(cells)
    names = [_cell_name(cells, cell) for cell in cells]
    ranked = sorted(range(len(cells)), key=lambda k: -float(np.nansum(cells[k].before ** 2)))
    first = sorted(ranked[:FIRST_LOADS]) if len(cells) > FIRST_LOADS else range(len(cells))
    panels = {
        k: {"title": names[k], "svg": Markup(load_panel(cell, gauges, limit, names[k], repaired))}
        for k, cell in enumerate(cells)
    }
    order = [gauges.index(place.name) for place in diagnosis.where.gauges]
    by_gauge = [Markup(gauge_panel(cells, g, gauges[g], repaired)) for g in order]
    after = f"difference once {_first_name(diagnosis)} is added to it" if repaired else ""
    return {
        "gap": gap_line(diagnosis),
        "legend": {"before": "difference to the twin", "after": after},
        "load_panels": [panels[k] for k in first],
        "more_loads": [panel for k, panel in panels.items() if k not in first],
        "gauge_panels": by_gauge[:FIRST_GAUGES],
        "more_gauges": by_gauge[FIRST_GAUGES:],
        "axis": axis_words(cells),
        "units": units_words(diagnosis),
        "numbers_head": [*NUMBERS, "With the effect"] if repaired else list(NUMBERS),
        "numbers": [row for cell in cells for row in _numbers(cell, gauges, repaired)],
    }


def _first_name(diagnosis: Diagnosis) -> str:
    return " and ".join(p.named.name for p in diagnosis.which[0].parameters) or "the effect"


def _cell_name(cells: tuple[MeasuredCell, ...], cell: MeasuredCell) -> str:
    load = shown(cell.load_words) if cell.load_words else ""
    if len({c.test for c in cells}) == 1:
        return _capital(load) or shown(cell.test)
    return f"{shown(cell.test)}, {load}" if load else shown(cell.test)


def _numbers(cell: MeasuredCell, gauges: tuple[str, ...], repaired: bool) -> list[list[str]]:
    columns = [cell.measured, cell.half_width, cell.twin, *([cell.repaired] if repaired else [])]
    return [
        [
            shown(name if cell.units[k] == MICROSTRAIN else f"{name} [{cell.units[k]}]"),
            shown(cell.test),
            shown(_amounts(cell.load)),
            *(digits_of(column[k], cell.units[k]) for column in columns),
        ]
        for k, name in enumerate(gauges)
        if not np.isnan(cell.measured[k])
    ]


def _amounts(load: Load) -> str:
    return ", ".join(f"{value:g}" for value in amounts_of(load))


def _where(diagnosis: Diagnosis) -> dict[str, Any]:
    nodes = [
        [n.words, node_name(n), percent(n.simulated), percent(n.real), percent(n.share)]
        for n in flipping_nodes(diagnosis)
    ]
    return {
        "places": place_lines(diagnosis),
        "maps": _maps(diagnosis),
        "sign": sign_of(diagnosis.posterior.model.inputs.twin.twin),
        "nodes": nodes if diagnosis.where.nodes else None,
    }


def _maps(diagnosis: Diagnosis) -> list[dict[str, str]]:
    """Return the gauges on the structure, coloured by the difference at the greatest load, before and after."""
    inputs = diagnosis.posterior.model.inputs
    cells, points = measured_cells(diagnosis), _points(inputs)
    if points is None:
        return []
    greatest = max((cell.load for cell in cells), key=lambda load: abs(inputs.share_of_reference(load)))
    top = [cell for cell in cells if cell.load == greatest]
    at = f" at {top[0].load_words}" if top[0].load_words else ""
    sides = [("Before", [cell.before / cell.scale for cell in top])]
    sides += [("After", [cell.after / cell.scale for cell in top])] if has_repair(diagnosis) else []
    means = [(name, _mean(rows)) for name, rows in sides]
    unit, most = top[0].unit, float(np.nanmax(np.abs(means[0][1]), initial=0.0))
    limit = max(most, 1.0) if unit in (MICROSTRAIN, MIXED) else most or 1.0
    outline = getattr(inputs.twin.twin, "outline", None)
    found = []
    for name, values in means:
        added = f", with {_first_name(diagnosis)} added" if name == "After" else ""
        caption = f"{name}: measured less predicted{at}{added}; most {amount(limit, unit)}"
        caption = caption if name == "Before" else caption.partition(";")[0]
        drawn = gauge_map(
            points, values, inputs.campaign.gauges, limit, outline, caption, unit, named_gauges(diagnosis)
        )
        found.append({"svg": Markup(drawn), "caption": f"{caption}."})
    return found


def _mean(rows: list[Floats]) -> Floats:
    """Return the mean (n_gauges,) of what was recorded, NaN where nothing was."""
    stacked = np.array(rows)
    count = np.isfinite(stacked).sum(axis=0)
    return np.asarray(np.where(count > 0, np.nansum(stacked, axis=0) / np.maximum(count, 1), np.nan))


def _points(inputs: Inputs) -> Floats | None:
    """Return the places (n_gauges, 2) [m] of the campaign's gauges; None where the twin does not say."""
    places = inputs.twin.gauge_positions
    return None if places is None else places[list(inputs.order), :2]


def _which(diagnosis: Diagnosis) -> dict[str, Any]:
    first = diagnosis.which[0]
    causes = [_cause(cause, explained(cause) if cause is first else []) for cause in shown_causes(diagnosis)]
    sizes = [[_capital(name), size] for name, size in detectable_sizes(diagnosis)]
    doubts = [line for line in doubt_lines(diagnosis) if not line.startswith("Detectable sizes")]
    return {"causes": causes, "doubts": doubts, "is_sound": diagnosis.is_sound, "sizes": sizes}


def _cause(cause: Cause, lines: list[str]) -> dict[str, Any]:
    return {
        "chance": likely(cause.probability),
        "share": _share(cause.probability),
        "words": _capital(cause_words(cause)),
        "lines": lines,
    }


def _share(part: float) -> str:
    return f"{100.0 * min(1.0, max(0.0, part)):.1f}%"


def _how_far(diagnosis: Diagnosis) -> dict[str, Any]:
    s = diagnosis.shrinkage
    if s is None:
        return {"closed": "No effect was added, so the gap does not close.", "folds": []}
    most = max([1e-9, *(h.before for h in s.held_out), *(h.after for h in s.held_out)])
    folds = [
        {
            "name": _capital(shown(h.name)),
            "before": amount(h.before, s.unit),
            "after": amount(h.after, s.unit),
            "before_share": _share(h.before / most),
            "after_share": _share(h.after / most),
        }
        for h in s.held_out
    ]
    return {"closed": closed_words(s), "folds": folds}


def _next(diagnosis: Diagnosis) -> dict[str, Any]:
    tests = diagnosis.next_test
    rows = [[_capital(p.words), f"{p.information / math.log(2):.2f} bits", f"{p.cost:g}"] for p in tests]
    return {"tests": rows, "test_note": NO_SUCH_TEST if tests and not any(p.is_strain_test for p in tests) else ""}
