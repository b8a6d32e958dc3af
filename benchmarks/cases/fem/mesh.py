"""Mesh convergence of the wing: pristine strain and both damage increments against a mesh many times finer."""

from collections.abc import Iterator, Sequence

import numpy as np

from benchmarks.cpu import Stopwatch
from benchmarks.tables import Line, markdown
from femlib.arrays import FloatArray
from femlib.wing import uav_wing

REFINEMENTS = (0.5, 0.7, 1.0, 1.4, 2.0)
REFERENCE = 3.1
STATES = np.array([[0.0, 0.0], [0.8, 0.0], [0.0, 0.8]])
LOAD_FACTOR = 3.0


def results(limit: float, threads: Sequence[int]) -> Iterator[Line]:
    """Yield a line per mesh; CPU seconds are those of building the wing and solving three states."""
    yield from compared(REFINEMENTS, REFERENCE)


def compared(refinements: Sequence[float], reference: float) -> Iterator[Line]:
    """Yield how far each mesh is from the reference: rms and most over the 20 usable gauges [%]."""
    exact, n_reference, _ = _increments(reference)
    for refinement in refinements:
        strains, n_unknowns, seconds = _increments(refinement)
        # pristine strain gauge by gauge, increments in percent of the largest
        scales = [np.abs(exact[0]), np.abs(exact[1]).max(), np.abs(exact[2]).max()]
        errors = [100.0 * (ours - theirs) / scale for ours, theirs, scale in zip(strains, exact, scales, strict=True)]
        line = {"size": f"refinement {refinement:g}", "seed": 0, "unknowns": n_unknowns, "cpu_seconds": seconds}
        line |= {"reference": reference, "times_finer": n_reference / n_unknowns}
        for name, error in zip(("pristine", "mu1", "mu2"), errors, strict=True):
            line |= {f"{name}_rms": float(np.sqrt(np.mean(error**2))), f"{name}_most": float(np.abs(error).max())}
        yield line


def _increments(refinement: float) -> tuple[FloatArray, int, float]:
    """Return pristine strain and the two increments (3, 20), the unknowns, and CPU seconds."""
    watch = Stopwatch()
    wing = uav_wing(refinement=refinement)
    strains = wing.strains_microstrain(STATES, LOAD_FACTOR)[:, wing.gauges.is_usable]
    strains[1:] -= strains[0]
    return strains, wing.structure.shells.mesh.n_dofs, watch.read()[0]


def summary(lines: Sequence[Line]) -> str:
    """Return the table of docs/wing.md."""
    head = ("refinement", "unknowns", "finer by", "pristine strain (most)", "mu1 increment", "mu2 increment", "CPU s")
    rows = []
    for line in lines:
        sizes = [line["size"].removeprefix("refinement "), f"{line['unknowns']:,}", f"{line['times_finer']:.1f}"]
        increments = [f"{line[f'{name}_rms']:.2f} %" for name in ("mu1", "mu2")]
        pristine = f"{line['pristine_rms']:.2f} % ({line['pristine_most']:.1f})"
        rows.append([*sizes, pristine, *increments, f"{line['cpu_seconds']:.1f}"])
    return markdown(head, rows)
