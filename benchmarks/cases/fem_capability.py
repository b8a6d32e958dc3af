"""What `built_wing` bears by the mesh: load factors at which the first ply fails, without and with lines near edges."""

import re
from collections.abc import Iterator, Sequence
from itertools import pairwise

import numpy as np

from benchmarks.cpu import Stopwatch
from benchmarks.tables import Line, markdown
from femlib.rom.capability import first_ply
from femlib.rom.zones import LEFT
from femlib.wing.built import built_wing
from femlib.wing.strength import wing_limits
from femlib.wing.structure import CARBON_LENGTH

MESHES = (
    *((refinement, 0.0) for refinement in (0.5, 1.0, 2.0, 3.0, 4.0)),
    *((0.5, CARBON_LENGTH / k) for k in (1, 2, 4, 8)),
    *((1.0, CARBON_LENGTH / k) for k in (4, 8)),
)
"""Refinements, and distances of the first lines beside edges of regions and layups [m]. A mesh of refinement 4 has
steps of 4 mm and takes 12 GB; lines are closer than that where strains change."""
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
            "refinement": refinement,
            "step": step,
            "unknowns": len(structure.supports.free),
            **borne,
            "cpu_seconds": cpu,
        }


def summary(lines: Sequence[Line]) -> str:
    """Return the table: values, and their distances from the limit of the last two; limits of halved steps beside."""
    columns = [f"{100 * lost:g} %" for lost in LOST]
    values = [np.array([line[c] for c in columns]) for line in lines]
    limits = [1.0 / (2.0 / own - 1.0 / before) for before, own in pairwise(values)]
    last, rows = limits[-1] if limits else values[-1], []
    for k, (line, own) in enumerate(zip(lines, values, strict=True)):
        off = [f"{100.0 * np.abs(found / last - 1.0).max():.1f} %" for found in (own, *limits[k - 1 : k])]
        rows.append([line["size"], line["unknowns"], *(f"{one:.3f}" for one in own), off[0]])
        if k and _is_halved(lines[k - 1], line):
            stated = f"{100.0 * LEFT * np.abs(own / limits[k - 1] - 1.0).max():.1f} %"
            rows[-1] += [", ".join(f"{one:.3f}" for one in limits[k - 1]), stated, off[1]]
    heads = ["refinement, first lines", "unknowns", *columns, "beside the last limit"]
    heads += ["limit with the mesh before", "its stated error", "beside the last"]
    return markdown(heads, [row + [""] * (len(heads) - len(row)) for row in rows])


def _is_halved(before: Line, line: Line) -> bool:
    return bool(line["refinement"] == before["refinement"] and line["step"] == 0.5 * before["step"] > 0.0)
