"""The page that plays a mission: one HTML file with its own style, script and data, nothing from elsewhere."""

import datetime
from collections.abc import Mapping, Sequence
from typing import Any

from octmip.errors import DataError
from octmip.input.names import shown
from octmip.interfaces.report.mission.data import Asset, fixed_data, steps_data, traced_gauges
from octmip.interfaces.report.mission.record import Course, MissionStep, Region, check_steps
from octmip.interfaces.report.page import page_facts, render
from octmip.monitor import Library, ParameterTree
from octmip.twin import Twin

MOST_EVENTS = 40
"""Events that the list of a page holds."""
FEW = 3
"""Changes of one kind that the first sentence names."""


def mission_page(
    steps: Sequence[MissionStep],
    library: Library,
    trees: Sequence[ParameterTree] = (),
    *,
    twin: Twin | None = None,
    limits: Mapping[str, float] | None = None,
    names: Mapping[str, str] | None = None,
    traced: Sequence[str] = (),
    course: Course | None = None,
    regions: Sequence[Region] = (),
    title: str = "Mission of an asset",
    about: str = "",
    data: str = "",
    made: datetime.date | None = None,
) -> str:
    """Return the page of a mission.

    Parameters
    ----------
    steps
        the mission: readings, what a `Monitor` made of them, decisions.
    library
        the states of the monitor's filter, or of its selector where it has no filter; its gauges order the readings.
    trees
        the trees at work, one per parameter; the way of each reading is shown in them.
    twin
        the model: the strain of the believed state is drawn beside the readings, and where it says where its gauges
        lie, the structure. None: the nearest state of the library is drawn.
    limits
        by parameter, the value beyond which caution is needed.
    names
        by parameter, what the page calls it.
    traced
        gauges whose strain is drawn; none: the three that move most, those that the trees read first.
    course
        the way of the asset, for steps that say where it is.
    regions
        the parts of the structure that the parameters are about.
    title, about
        heading, and one line below it.
    data
        where the readings are from, for the footer.
    made
        day of the page; today by default.

    Raises
    ------
    DataError
        there is no step, a reading has another length, a name is unknown.
    """
    asset = Asset(
        library, tuple(trees), twin, limits or {}, names or {}, tuple(traced) or traced_gauges(library, trees)
    )
    check_steps(list(steps), len(library.gauges))
    _check_names(asset, regions)
    entries = steps_data(asset, steps)
    fixed = fixed_data(asset, course, regions)
    return render(
        "mission.html",
        styles=("mission.css",),
        scripts=("mission.js",),
        facts=page_facts(data or None, None, made),
        title=title,
        about=about,
        summary=_summary(entries),
        figures=_figures(asset, entries),
        mission={**fixed, "steps": entries},
        parameters=[one["name"] for one in fixed["parameters"]],
        trees=[one["name"] for one in fixed["trees"]],
        has_course=course is not None,
        has_regions=bool(regions),
        has_structure=fixed["structure"] is not None,
        has_belief=entries[-1]["belief"] is not None,
        has_truth=entries[-1]["truth"] is not None,
        limited=[
            f"{one['name']} {100 * one['limit']:.3g} %" for one in fixed["parameters"] if one["limit"] is not None
        ],
        n_steps=len(entries),
        events=_events(entries)[:MOST_EVENTS],
    )


def _check_names(asset: Asset, regions: Sequence[Region]) -> None:
    parameters, gauges = asset.library.parameters, asset.library.gauges
    asked = [*asset.limits, *asset.names, *(region.parameter for region in regions)]
    asked += [tree.parameter for tree in asset.trees]
    unknown = [name for name in asked if name not in parameters]
    if unknown:
        raise DataError(f"the library has no parameter {unknown[0]!r}; expected one of {parameters}")
    lacking = [name for name in (*asset.traced, *(g for t in asset.trees for g in t.gauges)) if name not in gauges]
    if lacking:
        raise DataError(f"the library has no gauge {lacking[0]!r}; expected one of {gauges[:3]}...")


def _events(entries: Sequence[Mapping[str, Any]]) -> list[tuple[int, str]]:
    """Return the steps at which something happened, with what it was."""
    found = []
    for k, entry in enumerate(entries):
        if entry["refused"]:
            found.append((k, f"Reading refused: {entry['refused']}"))
        if entry["alarm"]:
            found.append((k, f"Alarm: {entry['alarm']}"))
        if entry["decision"] and k and entry["decision"] != entries[k - 1]["decision"]:
            found.append((k, f"Decision: {entry['decision']}"))
    return found


def _summary(entries: Sequence[Mapping[str, Any]]) -> str:
    """Return the mission in a sentence, in the order of its steps: decisions, alarms; then what was refused."""
    parts = [(0, f'at first "{entries[0]["decision"]}"')] if entries[0]["decision"] else []
    turns = [k for k in range(1, len(entries)) if entries[k]["decision"] != entries[k - 1]["decision"]]
    parts += [(k, f'"{entries[k]["decision"]}" from step {k}') for k in turns[:FEW]]
    alarms = [k for k, entry in enumerate(entries) if entry["alarm"]]
    parts += [(k, f"alarm of the watch at step {k}") for k in alarms[:FEW]]
    words = [part for _, part in sorted(parts, key=lambda part: part[0])]
    more = len(turns[FEW:]) + len(alarms[FEW:])
    words += [f"{more} more changes, listed below"] if more else []
    words += ["no alarm of the watch"] if not alarms and any(entry["p"] is not None for entry in entries) else []
    refused = sum(bool(entry["refused"]) for entry in entries)
    words += [f"{refused} reading{'s' if refused > 1 else ''} refused"] if refused else []
    sentence = "; ".join(words) or f"{len(entries)} readings"
    return f"{sentence[:1].upper()}{sentence[1:]}."


def _figures(asset: Asset, entries: Sequence[Mapping[str, Any]]) -> list[tuple[str, ...]]:
    """Return the key figures: what is believed at the end, steps, alarms."""
    figures: list[tuple[str, ...]] = []
    for k, name in enumerate(asset.library.parameters):
        believed = entries[-1]["belief"]
        if believed is not None and k < 4:
            own = believed[k]
            over = own["median"] > asset.limits.get(name, float("inf"))
            note = f"90 %: {100 * own['low']:.0f} to {100 * own['high']:.0f} %, at the end"
            figures.append(
                (f"Believed {asset.called(name)}", f"{100 * own['median']:.0f} %", note, "warn" if over else "")
            )
    cautious = sum(entry["cautious"] for entry in entries)
    figures.append(("Steps", f"{len(entries)}", f"{cautious} of them cautious"))
    alarms = sum(bool(entry["alarm"]) for entry in entries)
    figures.append(("Alarms", f"{alarms}", shown("of the watch"), "warn" if alarms else ""))
    return figures
