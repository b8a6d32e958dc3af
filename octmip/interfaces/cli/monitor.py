"""From a twin to a folder of trees, pages and C: `octmip.interfaces.cli.options.monitor` says how it is called."""

import argparse
import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from octmip.errors import DataError
from octmip.formats.files import make_folder, write_bytes
from octmip.formats.names import visible
from octmip.formats.tree_file import record_tree, write_tree_file
from octmip.gap.doors import open_twin
from octmip.gap.twins.cached import CachedTwin
from octmip.interfaces.cli.answer import ElapsedLine, print_json
from octmip.interfaces.report.html import tree_page
from octmip.interfaces.report.text import number, tree_text
from octmip.interfaces.report.tree.evidence import gather, judged_by
from octmip.monitor.export import c_source
from octmip.sensing.monitor_design import MonitorDesign, design_monitor
from octmip.trees.solution import Limits
from octmip.trees.tradeoff.held_out import Samples
from octmip.twin import Twin, load_of, load_words, loads_of, units_of

UNSAFE = "/\\\0"
"""What the name of a state may not hold, as it names files."""


def run(arguments: argparse.Namespace) -> int:
    """Make the folder and show what the trees are worth."""
    twin = CachedTwin(open_twin(arguments.twin, arguments.card, arguments.linear))
    loads = [_numbers(words, "--load") for words in arguments.load] or [dict.fromkeys(loads_of(twin), 1.0)]
    settings: dict[str, Any] = {
        "noise_sd": _noise(twin, arguments.noise),
        "levels": {name: levels for words in arguments.states for name, levels in _levels(words).items()},
        "costs": {name: cost for words in arguments.cost for name, cost in _numbers(words, "--cost").items()},
        "depth": arguments.depth,
        "budget": arguments.budget,
        "n_draws": arguments.draws,
        "seed": arguments.seed,
        "limits": Limits(seconds=arguments.seconds),
    }
    found = []
    for k, load in enumerate(loads, start=1):
        folder = Path(arguments.out) / (f"load-{k}" if len(loads) > 1 else "")
        with ElapsedLine(f"monitoring at {_at(twin, load)}"):
            design = design_monitor(twin, load, **settings)
            _write(folder, design, twin)
        found.append(_summary(design, twin, load, folder))
        if not arguments.json:
            print(_words(design, found[-1]))
    if arguments.json:
        print_json({"monitors": found})
    return 0


def _write(folder: Path, design: MonitorDesign, twin: Twin) -> None:
    """Write the tree, the page and the C function of each state, and the selector of all.

    Raises
    ------
    DataError
        a state has a name that no file may have.
    WriteError
        the folder cannot be made or written.
    """
    make_folder(folder)
    units = dict(zip(twin.gauges, units_of(twin), strict=True))
    for k, (one, problem, solution) in enumerate(zip(design.trees, design.problems, design.solutions, strict=True)):
        if set(one.parameter) & set(UNSAFE):
            raise DataError(f"state {one.parameter!r} holds one of {UNSAFE!r}, so it names no file; rename it")
        place, file = folder / one.parameter, record_tree(problem, solution, target_column=one.parameter)
        write_tree_file(f"{place}.json", file)
        called = f"{one.parameter}_level" if re.fullmatch(r"[A-Za-z]\w*", one.parameter, re.ASCII) else "level"
        write_bytes(f"{place}.c", c_source(one.tree, one.gauges, one.values, name=called).encode())
        codes = np.searchsorted(one.values, design.library.states[design.truth, k])
        samples = Samples(design.fresh, codes, np.ones(len(codes)))
        evidence = judged_by(gather(file, problem, seconds=0.0), file, samples, "fresh readings of the twin")
        page = tree_page(file, f"{one.parameter}.json", evidence, units=units)
        write_bytes(f"{place}.html", page.encode())
    design.selector.write(folder / "monitor.json")


def _summary(design: MonitorDesign, twin: Twin, load: Mapping[str, float], folder: Path) -> dict[str, Any]:
    library = design.library
    parts = zip(design.trees, design.solutions, design.off_by, design.without_readings, strict=True)
    return {
        "folder": str(folder),
        "load": dict(load),
        "holds_for": "this load" if library.only_load is not None else "every multiple of this load",
        "readings_divided_by": library.asked_at[1] if library.reference is None else 1.0,
        "sensors": list(design.sensors),
        "states": [
            {
                "name": one.parameter,
                "levels": list(one.values),
                "objective": solution.objective,
                "bound": solution.bound,
                "is_optimal": solution.is_optimal,
                "off_by_on_fresh_readings": off,
                "off_by_without_readings": blind,
            }
            for one, solution, off, blind in parts
        ],
        "n_fresh_readings": len(design.fresh),
    }


def _words(design: MonitorDesign, summary: Mapping[str, Any]) -> str:
    """Return what the trees are worth on new readings, and the trees."""
    load = ", ".join(f"{name} {value:g}" for name, value in summary["load"].items())
    lines = [f"{visible(summary['folder'])}: read {', '.join(map(visible, design.sensors)) or 'nothing'}"]
    if load:
        lines[0] += f" at {visible(load)}; the trees hold for {summary['holds_for']}"
    if summary["readings_divided_by"] != 1.0:
        lines.append(f"thresholds are of readings divided by {summary['readings_divided_by']:g}")
    for state, one, problem in zip(summary["states"], design.trees, design.problems, strict=True):
        off, blind = state["off_by_on_fresh_readings"], state["off_by_without_readings"]
        proof = "proven best in training" if state["is_optimal"] else f"bound in training {number(state['bound'])}"
        lines.append(
            f"{visible(one.parameter)}: off by {off:.3g} on average on {summary['n_fresh_readings']} fresh readings "
            f"({blind:.3g} without any); {proof}"
        )
        lines.append(tree_text(one.tree, problem.feature_names, problem.class_names))
    return "\n".join(lines)


def _at(twin: Twin, load: Mapping[str, float]) -> str:
    names = loads_of(twin)
    return load_words(names, load_of(names, tuple(load.values()))) if len(load) == len(names) > 0 else "its readings"


def _noise(twin: Twin, given: Sequence[str]) -> dict[str, float]:
    """Return the noise of each reading: of all, then of units, then of single readings.

    Raises
    ------
    DataError
        a name is neither a unit nor a reading, or a reading has none.
    """
    units = dict(zip(twin.gauges, units_of(twin), strict=True))
    every = [words for words in given if "=" not in words]
    found = {name: _number(words, "--noise") for words in every for name in units}
    named = {name: sd for words in given if "=" in words for name, sd in _numbers(words, "--noise").items()}
    unknown = [name for name in named if name not in units and name not in units.values()]
    if unknown:
        raise DataError(
            f"--noise names {unknown[0]!r}; expected a unit among {sorted(set(units.values()))} or a reading among "
            f"{list(units)}; correct the name"
        )
    found |= {name: named[unit] for name, unit in units.items() if unit in named}
    found |= {name: sd for name, sd in named.items() if name in units}
    missing = [name for name in units if name not in found]
    if missing:
        raise DataError(f"--noise says nothing of {missing[0]!r} [{units[missing[0]]}]; give {units[missing[0]]}=SD")
    return found


def _levels(words: str) -> dict[str, list[float]]:
    """Return the levels of one state, as NAME=LEVEL,... says them."""
    name, sign, levels = words.partition("=")
    if not sign:
        raise DataError(f"--states is {words!r}; expected NAME=LEVEL,... such as crack=0,0.2,0.4; give these")
    return {name: [_number(level, "--states") for level in levels.split(",")]}


def _numbers(words: str, option: str) -> dict[str, float]:
    """Return the numbers that NAME=VALUE,... says."""
    pairs = [part.rpartition("=") for part in words.split(",")]
    if not all(sign for _, sign, _ in pairs):
        raise DataError(f"{option} is {words!r}; expected NAME=VALUE, several with a comma between; give these")
    return {name: _number(value, option) for name, _, value in pairs}


def _number(word: str, option: str) -> float:
    try:
        return float(word)
    except ValueError as error:
        raise DataError(f"{option} holds {word!r}; expected a number; correct it") from error
