"""What `built_wing` bears by the mesh: load factors at which the first ply fails, without and with lines near edges."""

import re
from collections.abc import Iterator, Sequence

import numpy as np

from benchmarks.cpu import Stopwatch
from benchmarks.tables import Line, markdown
from femlib.rom.capability import SAFETY, first_ply
from femlib.wing.built import built_wing
from femlib.wing.strength import wing_limits
from femlib.wing.structure import CARBON_LENGTH

MESHES = (
    *((refinement, 0.0) for refinement in (0.5, 1.0, 2.0)),
    *((0.5 * k, CARBON_LENGTH / k) for k in (1, 2, 4)),
)
"""Refinements, and distances of the first lines beside edges of regions and layups [m]; halved, each is the next.
Refinement 4 takes more than 16 GB."""
LOST = (0.0, 0.4, 0.8)
"""Of region 1."""


def results(limit: float, threads: Sequence[int], only: str = "") -> Iterator[Line]:
    """Yield the load factors of each mesh; `only` (a regular expression) chooses among "0.5, 3.8 mm" and others."""
    for refinement, step in MESHES:
        size = f"{refinement:g}, {1e3 * step:.2g} mm"
        if not re.fullmatch(only or ".*", size):
            continue
        watch = Stopwatch()
        wing = built_wing(refinement=refinement, edge_step=step)
        limits, structure = wing_limits(wing), wing.structure
        states = np.array([[lost, 0.0] for lost in LOST])
        moved = [structure.solve(state[None], wing.lift)[0] for state in states]
        borne = {f"{100 * lost:g} %": first_ply(structure, limits, u) for lost, u in zip(LOST, moved, strict=True)}
        cpu = round(watch.read()[0], 1)
        yield {
            "size": size,
            "seed": 0,
            "unknowns": len(structure.supports.free),
            **borne,
            "cpu_seconds": cpu,
        }


def summary(lines: Sequence[Line]) -> str:
    """Return the table: values, the stated error of each mesh (by the next one) and the distance from the last."""
    columns = [f"{100 * lost:g} %" for lost in LOST]
    rows = []
    for k, line in enumerate(lines):
        has_next = k + 1 < len(lines) and not str(lines[k + 1]["size"]).startswith("0.5")
        apart = [max(abs(line[c] / lines[j][c] - 1.0) for c in columns) for j in (k + has_next, -1)]
        errors = [f"{100 * SAFETY * apart[0]:.1f} %" if has_next else "", f"{100 * apart[1]:.1f} %"]
        rows.append([line["size"], line["unknowns"], *(f"{line[c]:.3f}" for c in columns), *errors])
    return markdown(["refinement, first lines", "unknowns", *columns, "stated error", "beside the finest"], rows)
