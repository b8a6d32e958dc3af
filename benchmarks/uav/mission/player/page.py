"""The page that plays a mission: one HTML file with its own style, script and data, nothing from elsewhere."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from benchmarks.uav.mission.player.data import Asset, fixed_data, steps_data
from benchmarks.uav.mission.player.record import Course, MissionStep, Region
from octmip.input.names import shown
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
    trees: Sequence[ParameterTree],
    *,
    twin: Twin,
    limits: Mapping[str, float],
    traced: Sequence[str],
    course: Course,
    regions: Sequence[Region],
    title: str,
    about: str,
    data: str,
) -> str:
    """Return the page of a mission.

    Parameters
    ----------
    steps
        the mission: readings, what a `Monitor` made of them, decisions.
    library
        the states of the monitor's filter; its gauges order the readings.
    trees
        the trees at work, one per parameter; the way of each reading is shown in them.
    twin
        the model: the strain of the believed state is drawn beside the readings, and the structure.
    limits
        by parameter, the value beyond which caution is needed.
    traced
        gauges whose strain is drawn.
    course
        the way of the asset.
    regions
        the parts of the structure that the parameters are about.
    title, about
        heading, and one line below it.
    data
        where the readings are from, for the footer.
    """
    asset = Asset(library, tuple(trees), twin, limits, tuple(traced))
    entries = steps_data(asset, steps)
    fixed = fixed_data(asset, course, regions)
    return render(
        "mission.html",
        folder=Path(__file__).parent,
        styles=("mission.css",),
        scripts=("mission.js",),
        facts=page_facts(data),
        title=title,
        about=about,
        summary=_summary(entries),
        figures=_figures(asset, entries),
        mission={**fixed, "steps": entries},
        parameters=library.parameters,
        trees=[one["name"] for one in fixed["trees"]],
        limited=[f"{name} {100 * limit:.3g} %" for name, limit in limits.items()],
        n_steps=len(entries),
        events=_events(entries)[:MOST_EVENTS],
    )


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
            figures.append((f"Believed {name}", f"{100 * own['median']:.0f} %", note, "warn" if over else ""))
    cautious = sum(entry["cautious"] for entry in entries)
    figures.append(("Steps", f"{len(entries)}", f"{cautious} of them cautious"))
    alarms = sum(bool(entry["alarm"]) for entry in entries)
    figures.append(("Alarms", f"{alarms}", shown("of the watch"), "warn" if alarms else ""))
    return figures
