"""The wing against CalculiX on the exported deck: gauge strains, linear and with large deflection."""

import shutil
from collections.abc import Iterator, Sequence

import numpy as np

from benchmarks.tables import Line
from benchmarks.wing.calculix import LOAD_FACTOR, calculix
from femlib.arrays import FloatArray
from femlib.wing import Wing, bend, uav_wing

HEALTHY: dict[str, float] = {}
DAMAGED = {"mu1": 0.8, "mu2": 0.8}
LINEAR = ((HEALTHY, 1.0), (DAMAGED, 1.0), (HEALTHY, 0.5))
BENT = ((HEALTHY, 0.5), (DAMAGED, 0.5))


def results(limit: float, threads: Sequence[int]) -> Iterator[Line]:
    """Yield a line per state and mesh; one line that says so where CalculiX (ccx) is not installed."""
    if shutil.which("ccx") is None:
        yield {"size": "all", "seed": 0, "outcome": "skipped: CalculiX (ccx) is not installed"}
        return
    for state, refinement in LINEAR:
        yield linear(state, refinement)
    for state, refinement in BENT:
        yield bent(state, refinement)


def linear(state: dict[str, float], refinement: float) -> Line:
    """Return how far the strains of a state are from CalculiX [%], over all 24 gauges and over the usable ones."""
    wing = uav_wing(refinement=refinement)
    theirs = calculix(wing, state, False, False)
    error = 100.0 * (wing.strain_microstrain(state, LOAD_FACTOR) / theirs - 1.0)
    return (
        _line("linear", state, refinement, wing) | _sizes("all", error) | _sizes("usable", error[wing.gauges.is_usable])
    )


def bent(state: dict[str, float], refinement: float) -> Line:
    """Return by how much the change of strain through large deflection differs from CalculiX's [% of strain]."""
    wing = uav_wing(refinement=refinement)
    before = wing.strain_microstrain(state, LOAD_FACTOR)
    ours = 100.0 * (bend(wing, state, LOAD_FACTOR).strain_microstrain / before - 1.0)
    theirs = 100.0 * (calculix(wing, state, False, True) / calculix(wing, state, False, False) - 1.0)
    error, usable = ours - theirs, wing.gauges.is_usable
    line = _line("large deflection", state, refinement, wing) | _sizes("all", error) | _sizes("usable", error[usable])
    return line | {"change_least": float(theirs[usable].max()), "change_most": float(theirs[usable].min())}


def _line(kind: str, state: dict[str, float], refinement: float, wing: Wing) -> Line:
    words = ", ".join(f"{name} {loss:.0%}" for name, loss in state.items()) or "healthy"
    unknowns = wing.structure.shells.mesh.n_dofs
    size = f"{kind}, {words}, refinement {refinement:g}"
    return {"size": size, "seed": 0, "kind": kind, "state": words, "refinement": refinement, "unknowns": unknowns}


def _sizes(name: str, error: FloatArray) -> dict[str, float]:
    return {f"{name}_rms": float(np.sqrt(np.mean(error**2))), f"{name}_most": float(np.abs(error).max())}


def summary(lines: Sequence[Line]) -> str:
    """Return the table of docs/wing.md."""
    rows = ["| what | state | refinement | rms of 24 | most of 24 | rms of 20 | most of 20 |", "|" + "---|" * 7]
    for line in lines:
        if "outcome" in line:
            return str(line["outcome"])
        figures = [f"{line[key]:.2f} %" for key in ("all_rms", "all_most", "usable_rms", "usable_most")]
        rows.append(f"| {line['kind']} | {line['state']} | {line['refinement']:g} | " + " | ".join(figures) + " |")
    return "\n".join(rows)
