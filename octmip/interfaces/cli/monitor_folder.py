"""The folder of a monitor: trees, pages, C and JSON, and what the command says of them."""

import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from octmip.errors import DataError
from octmip.formats.tree_file import Readings, record_tree, write_tree_file
from octmip.input.files import make_folder, write_bytes
from octmip.input.names import visible
from octmip.interfaces.report.html import tree_page
from octmip.interfaces.report.text import number, tree_text
from octmip.interfaces.report.tree.evidence import gather, judged_by
from octmip.monitor.export import Legend, c_source
from octmip.sensing.monitor_design import MonitorDesign
from octmip.trees.tradeoff.held_out import Samples
from octmip.twin import Twin, units_of

UNSAFE = "/\\\0"
"""What the name of a state may not hold, as it names files."""


def write_monitor(folder: Path, design: MonitorDesign, twin: Twin) -> None:
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
    readings = Readings(units, dict(design.library.reference or {}))
    for k, (one, problem, solution) in enumerate(zip(design.trees, design.problems, design.solutions, strict=True)):
        if set(one.parameter) & set(UNSAFE):
            raise DataError(f"state {one.parameter!r} holds one of {UNSAFE!r}, so it names no file; rename it")
        place, file = folder / one.parameter, record_tree(problem, solution, one.parameter, readings=readings)
        write_tree_file(f"{place}.json", file)
        called = f"{one.parameter}_level" if re.fullmatch(r"[A-Za-z]\w*", one.parameter, re.ASCII) else "level"
        legend = Legend(one.parameter, readings)
        source = c_source(one.tree, one.gauges, one.values, name=called, legend=legend)
        write_bytes(f"{place}.c", source.encode())
        codes = np.searchsorted(one.values, design.library.states[design.truth, k])
        samples = Samples(design.fresh, codes, np.ones(len(codes)))
        evidence = judged_by(gather(file, problem, seconds=0.0), file, samples, "fresh readings of the twin")
        page = tree_page(file, f"{one.parameter}.json", evidence)
        write_bytes(f"{place}.html", page.encode())
    design.selector.write(folder / "monitor.json")


def summary_of(design: MonitorDesign, load: Mapping[str, float], folder: Path) -> dict[str, Any]:
    """Return what is said of a monitor as a JSON object."""
    library = design.library
    parts = zip(design.trees, design.solutions, design.off_by, design.without_readings, strict=True)
    return {
        "folder": str(folder),
        "load": dict(load),
        "holds_for": "this load" if library.only_load is not None else "every multiple of this load",
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


def words_of(design: MonitorDesign, summary: Mapping[str, Any]) -> str:
    """Return what the trees are worth on new readings, and the trees."""
    load = ", ".join(f"{name} {value:g}" for name, value in summary["load"].items())
    lines = [f"{visible(summary['folder'])}: read {', '.join(map(visible, design.sensors)) or 'nothing'}"]
    if load:
        lines[0] += f" at {visible(load)}; the trees hold for {summary['holds_for']}"
    for state, one, problem in zip(summary["states"], design.trees, design.problems, strict=True):
        off, blind = state["off_by_on_fresh_readings"], state["off_by_without_readings"]
        proof = "proven best in training" if state["is_optimal"] else f"bound in training {number(state['bound'])}"
        lines.append(
            f"{visible(one.parameter)}: off by {off:.3g} on average on {summary['n_fresh_readings']} fresh readings "
            f"({blind:.3g} without any); {proof}"
        )
        lines.append(tree_text(one.tree, problem.samples.feature_names, problem.samples.class_names))
    return "\n".join(lines)
