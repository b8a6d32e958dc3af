"""What is known of the instances: best trees and bounds with their proofs, and the runs of solvers on the files.

`known.json` holds three tables. "trees": by table, depth and features in a split, the fewest errors known, the bound,
and what proved it. "sizes": of each file. "runs": one object for each run of a solver on a file; whoever runs one adds
it.
"""

import json
from pathlib import Path
from typing import Any

from benchmarks import tables
from benchmarks.instances.catalogue import INSTANCES, Instance

FILE = Path(__file__).with_name("known.json")
RUN_KEYS = {"instance", "solver", "threads", "cpu_seconds", "objective", "bound"}


def known() -> dict[str, Any]:
    """Return the three tables.

    Raises
    ------
    ValueError
        a run names no instance, or lacks a figure, or contradicts a proof.
    """
    content: dict[str, Any] = json.loads(FILE.read_text())
    names = {instance.name: instance for instance in INSTANCES}
    for run in content["runs"]:
        if run.get("instance") not in names or set(run) < RUN_KEYS:
            raise ValueError(f"known.json has the run {run}; expected an instance of the catalogue and {RUN_KEYS}")
        best = content["trees"][tree_key(names[run["instance"]])]
        if run["bound"] is not None and run["bound"] > best["errors"]:
            raise ValueError(f"known.json has the run {run}, whose bound lies above a known tree: {best}")
    return content


def tree_key(instance: Instance) -> str:
    """Return the key of an instance among the trees: the same for every formulation of one problem."""
    return instance.name.partition("-")[2]


def markdown(content: dict[str, Any]) -> str:
    """Return the table of the instances: sizes, best tree and bound, and the best bound of a run on the file itself."""
    head = ["instance", "rows", "columns", "integers", "nonzeros", "best tree", "bound", "proven by", "on the file"]
    rows = []
    for instance in INSTANCES:
        size, best = content["sizes"][instance.name], content["trees"][tree_key(instance)]
        runs = [run for run in content["runs"] if run["instance"] == instance.name]
        cells = [f"`{instance.name}`", *(f"{size[key]:,}" for key in ("rows", "columns", "integers", "nonzeros"))]
        cells += [str(best["errors"]), str(best["bound"]), best["proof"], "; ".join(map(_run, runs)) or "open"]
        rows.append(cells)
    return tables.markdown(head, rows)


def _run(run: dict[str, Any]) -> str:
    bound = "no bound" if run["bound"] is None else f"bound {run['bound']:g}"
    return f"{run['solver']}: {bound}, {run['cpu_seconds']:g} CPU s"
