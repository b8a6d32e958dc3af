"""The course as a task for `octmip.monitor.Planner`: places along it and between its lines, and what a step costs.

A place is a point on a grid of the way left and of the share of the way from the tight to the wide line, so the plan
counts the way across when the aircraft changes the line; between its points a step is shared among four.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array

from benchmarks.uav.mission import course
from benchmarks.uav.mission.capable import Capable, chance_of_failing
from octmip.monitor import Action, Growth, Library, Planner

Floats = NDArray[np.float64]

LOST = 2000.0
"""Cost of the loss of an aircraft, in steps of flight: twenty missions."""
TIGHT_STEPS, WIDE_STEPS = 92, 102
LOADS = (2.0, 3.0)
WAY, N_WIDTHS = 3.5, 14
"""Grid of the way left [m], shorter than any step, and number of its lines."""
POINTS = 5
"""Points along each side of a cell over which its chance of failing is a mean."""


def course_plan(library: Library, growths: Sequence[Growth], capable: Capable) -> Planner:
    """Return the plan over a library's cells; `growths` are those at each of LOADS."""
    bears = cell_points(library, capable)
    actions = [
        Action(f"{load:g} g", 1.0, chance_of_failing(bears, load).mean(axis=1), growth, _onward(load))
        for load, growth in zip(LOADS, growths, strict=True)
    ]
    return Planner.of(actions, LOST, _onward(LOADS[0]).shape[0] - 1)


def place_of(x: Floats, width: Floats) -> NDArray[np.intp]:
    """Return the nearest place (n,) to points x (n,) along the course and between its lines (n,)."""
    left = np.rint(np.clip(course.GOAL - x, WAY, course.GOAL) / WAY)
    return np.asarray(1 + (left - 1) * N_WIDTHS + np.rint(width * (N_WIDTHS - 1)), dtype=np.intp)


def cell_points(library: Library, capable: Capable) -> Floats:
    """Return the capabilities (n_states, POINTS^2) at points spread over each cell [g]."""
    offsets = (np.arange(POINTS) + 0.5) / POINTS - 0.5
    both = np.stack(np.meshgrid(offsets, offsets), axis=-1).reshape(-1, 2) * library.widths
    points = np.clip(library.states[:, None] + both, 0.0, None)
    return capable.bears(points.reshape(-1, 2)).reshape(len(points), -1)


def _onward(load: float) -> csr_array:
    """Return where a step at a load leads from every place: shares (n_places, n_places), 0 the goal."""
    n = int(np.ceil(course.GOAL / WAY))
    left, line = (axis.ravel() for axis in np.meshgrid(np.arange(1, n + 1), np.arange(N_WIDTHS), indexing="ij"))
    x, width = course.advance(
        course.GOAL - WAY * left.astype(np.float64), line / (N_WIDTHS - 1.0), np.full(len(left), load < LOADS[1])
    )
    further, across = np.maximum(0.0, (course.GOAL - x) / WAY), width * (N_WIDTHS - 1)
    rows, columns, shares = [], [], []
    for up in (0, 1):
        for wide in (0, 1):
            i, j = np.floor(further).astype(int) + up, np.minimum(np.floor(across).astype(int) + wide, N_WIDTHS - 1)
            share = np.abs(1 - up - further % 1.0) * np.abs(1 - wide - across % 1.0)
            rows.append(1 + (left - 1) * N_WIDTHS + line)
            columns.append(np.where(i > 0, 1 + (i - 1) * N_WIDTHS + j, 0))
            shares.append(share)
    kept = np.concatenate(shares) > 0.0
    data, at = np.concatenate(shares)[kept], (np.concatenate(rows)[kept], np.concatenate(columns)[kept])
    return csr_array((data, at), shape=(n * N_WIDTHS + 1, n * N_WIDTHS + 1))
