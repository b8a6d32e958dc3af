"""The loop of `octmip monitor`: readings that leave the library, where to inspect, trees that know what was found."""

import argparse
import hashlib
import json
from collections import Counter
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from octmip.errors import DataError, OctmipError
from octmip.formats.tree_file import read_tree_file
from octmip.gap.campaign.reader import UNKNOWN_STATES, read_campaign
from octmip.input.files import whole_folder, write_bytes
from octmip.input.names import visible
from octmip.interfaces.cli.answer import print_json, print_notes
from octmip.interfaces.cli.monitor_folder import write_monitor
from octmip.interfaces.cli.stages import StageLine
from octmip.interfaces.cli.streams import prints_aside
from octmip.interfaces.report.change import change_page
from octmip.interfaces.report.text import number
from octmip.monitor import ModelSelector, ParameterTree
from octmip.monitor.library import Applied
from octmip.sensing.enrichment import SIGNIFICANT, Enriched, PartOf, Seen, TreeChange, enrich, watched
from octmip.trees.nodes.tree import depth
from octmip.trees.nodes.tree_nodes import encode_tree
from octmip.twin import Twin, amounts_of, loads_of

MOST_PLACES = 5
"""Places to inspect that are shown."""


def run_loop(arguments: argparse.Namespace, twin: Twin, settings: dict[str, Any]) -> int:
    """Watch the readings, and make the enriched monitor where they leave the library."""
    old, out = Path(arguments.deployed), Path(arguments.out)
    if out.resolve() == old.resolve():
        raise DataError(f"--out {out} is the deployed folder; expected another, so that both can be compared; name one")
    selector, trees = _deployed(old)
    if arguments.inspected:  # refused before anything is watched
        PartOf(twin, (arguments.inspected,))
    readings, loads, notes = _series(arguments.readings, twin, selector)
    with StageLine("watching"), prints_aside():
        seen = watched(twin, selector, readings, loads)
    found: dict[str, Any] = {"readings": arguments.readings, "deployed": str(old), "watch": _watch_json(seen)}
    found["notes"] = list(notes)
    added = arguments.inspected or (seen.finding.name if seen.finding and seen.finding.kind == "damage" else "")
    if not arguments.json:
        print_notes(notes)
        print("\n".join(_watch_words(arguments.readings, seen, added)))
    if added:
        since = seen.finding.since if seen.finding else 0
        settings |= {"depth": max(arguments.depth, *(depth(one.tree) for one in trees))}
        with whole_folder(out) as passing:
            with StageLine(f"training trees that know {added}"), prints_aside():
                enriched = enrich(twin, selector, trees, readings, loads, added, since, **settings)
                write_monitor(passing, enriched.design, twin)
            found |= _change_json(enriched, trees)
            write_bytes(passing / "change.json", (json.dumps(found, indent=1, allow_nan=False) + "\n").encode())
            write_bytes(passing / "change.html", change_page(found).encode())
        if not arguments.json:
            print("\n".join(_change_words(enriched, out)))
    if arguments.json:
        print_json(found)
    return 0


def _deployed(folder: Path) -> tuple[ModelSelector, list[ParameterTree]]:
    """Return the library at work, and one tree for each of its parameters.

    Raises
    ------
    DataError
        the folder is none that the command wrote, or a tree is that of another state.
    """
    if not (folder / "monitor.json").is_file():
        raise DataError(
            f"--deployed {folder} has no monitor.json; expected a folder that octmip monitor wrote; give its --out"
        )
    selector, trees = ModelSelector.read(folder / "monitor.json"), []
    if selector.library.reference is None:
        raise DataError(
            f"{folder / 'monitor.json'} is of readings divided by the load; expected one of readings as they are, at a "
            "load that it names; make it again with octmip monitor --load"
        )
    for name in selector.library.parameters:
        file = read_tree_file(folder / f"{name}.json")
        if file.target_column not in (None, name):
            raise DataError(
                f"{folder / name}.json is a tree of {file.target_column!r}; expected one of {name!r}; copy it again"
            )
        trees.append(ParameterTree.of(file, name, 1.0))
    return selector, trees


def _series(
    path: str, twin: Twin, selector: ModelSelector
) -> tuple[NDArray[np.float64], list[Applied], tuple[str, ...]]:
    """Return readings (n, n_gauges) in the library's order, NaN where missing, their loads, and how they were read."""
    campaign = read_campaign(path, twin)
    gauges = selector.library.gauges
    readings = np.full((len(campaign.readings), len(gauges)), np.nan)
    for column, name in enumerate(campaign.gauges):
        if name in gauges:
            readings[:, gauges.index(name)] = campaign.readings[:, column]
    names = loads_of(twin)
    applied: list[Applied] = [0.0] * len(readings)
    for cell in campaign.cells:
        for row in cell.rows.tolist():
            applied[row] = dict(zip(names, amounts_of(cell.load), strict=True))
    for load, line in zip(applied, campaign.numbers, strict=True):
        try:
            selector.library.checked_load(load)
        except OctmipError as error:
            raise DataError(f"{path}, row {line}: {error}") from error
    told = tuple(note for note in campaign.notes if note != UNKNOWN_STATES)  # states are what is monitored
    return readings, applied, told


def _watch_json(seen: Seen) -> dict[str, Any]:
    finding = seen.finding
    return {
        "n_readings": seen.n_readings,
        "n_tested": seen.n_tested,
        "damages_looked_for": seen.candidates,
        "alarm": seen.alarm,
        "faulty_gauges": list(seen.faulty),
        "words": finding.words if finding else "",
        "inspect": [
            {"kind": kind, "name": name, "probability": round(part, 6)}
            for kind, name, part in (finding.ranking[:MOST_PLACES] if finding else ())
        ],
    }


def _watch_words(source: str, seen: Seen, added: str) -> list[str]:
    lines = [
        f"{visible(source)}: gauge {visible(name)} is left out: it is faulty, or damage is at it alone"
        for name in seen.faulty
    ]
    if seen.finding is None and not seen.n_tested:
        lines.append(
            f"{visible(source)}: no reading has gauges enough to disagree with the library, so nothing was tested; "
            "expected more gauges than the library has states to tell apart; add columns"
        )
        return lines
    if seen.finding is None:
        some = "" if seen.n_tested == seen.n_readings else f" ({seen.n_tested} with gauges enough to be tested)"
        what = "the other gauges" if seen.faulty else "them"
        number_of = f"{seen.n_readings} reading{'s' * (seen.n_readings != 1)}"
        lines.append(f"{visible(source)}: no alarm in {number_of}{some}; the library explains {what}")
        return lines
    lines.append(
        f"{visible(source)}: alarm at reading {seen.alarm} of {seen.n_readings}. {visible(seen.finding.words)}"
    )
    places = [(name or kind, part) for kind, name, part in seen.finding.ranking if part >= 0.005][:MOST_PLACES]
    lines.append("inspect: " + ", ".join(f"{visible(name)} ({100 * part:.0f} %)" for name, part in places))
    if not added:
        lines.append("no damage of the twin explains the readings; inspect, and name what is found by --inspected")
    return lines


def _change_json(enriched: Enriched, deployed: list[ParameterTree]) -> dict[str, Any]:
    library, changes = enriched.design.library, []
    before, now = ({one.parameter: _digest(one) for one in trees} for trees in (deployed, enriched.design.trees))
    for one in enriched.changes:
        changes.append(
            {
                "state": one.parameter,
                "change": one.verdict,
                "splits": list(one.splits),
                "deployed_off_by": one.deployed,
                "retrained_off_by": one.retrained,
                "standard_error": one.standard_error,
                "objective": one.objective,
                "bound": one.bound,
                "is_optimal": one.is_optimal,
                "sha256_deployed": before.get(one.parameter),
                "sha256": now[one.parameter],
            }
        )
    return {
        "added": enriched.added,
        "states_before": enriched.n_before,
        "states": library.n_states,
        "largest_error_bound_of_twin": enriched.largest_bound,
        "n_fresh_readings": len(enriched.design.fresh),
        "trees": changes,
        "readings_since": enriched.again.n_readings,
        "told_since": {f"{level:g}": count for level, count in sorted(Counter(enriched.told.tolist()).items())},
        "alarm_of_enriched_library": enriched.again.alarm,
    }


def _digest(one: ParameterTree) -> str:
    """Return the sha256 of a tree alone: two files of one tree differ in the data that each was trained on."""
    values = tuple(round(value, 12) for value in one.values)
    return hashlib.sha256(json.dumps(encode_tree(one.tree, one.gauges, values)).encode()).hexdigest()


def _change_words(enriched: Enriched, out: Path) -> list[str]:
    bound = enriched.largest_bound
    proof = "" if bound is None else f"; the twin's error bound there is {bound:.2g} at most"
    lines = [
        f"{visible(str(out))}: the library has {enriched.design.library.n_states} states instead of "
        f"{enriched.n_before}, with {visible(enriched.added)}{proof}"
    ]
    lines += [_tree_words(one) for one in enriched.changes]
    counts = Counter(enriched.told.tolist())
    if counts:
        level, count = counts.most_common(1)[0]
        lines.append(
            f"since the damage was there, {visible(enriched.added)} reads {level:g} in {count} of {len(enriched.told)} "
            "readings"
        )
    again = enriched.again
    lines.append(f"the enriched library explains these {again.n_readings} readings")
    if again.finding is not None:
        lines[-1] = f"alarm of the enriched library at reading {again.alarm} of these: {visible(again.finding.words)}"
    return [*lines, f"see {visible(str(out / 'change.html'))}"]


def _tree_words(one: TreeChange) -> str:
    proof = "proven best in training" if one.is_optimal else f"bound in training {number(one.bound)}"
    name = visible(one.parameter)
    if one.deployed is None:
        return f"{name}: new, off by {one.retrained:.3g} on fresh readings; {proof}"
    if one.verdict == "kept":
        return (
            f"{name}: kept, off by {one.deployed:.3g} on fresh readings ({one.retrained:.3g} if trained again, within "
            f"{SIGNIFICANT:g} standard errors)"
        )
    places = f"{len(one.splits)} place{'s' * (len(one.splits) > 1)}"
    return f"{name}: changed in {places}, off by {one.retrained:.3g} instead of {one.deployed:.3g}; {proof}"
