"""The candidates for what follows a reversal: the force of the twin, and with slack, wind-up or delay in it.

The twin says force = mu T sign(velocity), with T the tension at the tight end. A drum that is driven through a spring
with play follows another path: with s the way since the reversal, u(F) = w (F / F0)^p the wind-up under a force F, P
the friction force before and Q after the reversal,

    F = -F0 ((u(P) - s) / w)^(1/p)                      for s < u(P)                the old wind-up is given back,
    F = 0                                               for u(P) < s < u(P) + g     the backlash g is crossed,
    F = min(Q, F0 ((s - u(P) - g) / w)^(1/p))           beyond                      the band winds up again.

F0 is the series' median friction force, so w is the wind-up at it. `s` may be the displacement [in], the time [s] or
the displacement over the amplitude: which of them makes all tests alike says what the slack is made of.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np
from scipy.optimize import least_squares

from benchmarks.real.damper.cycles import Samples
from femlib.arrays import FloatArray

COORDINATES: Mapping[str, str] = {"stroke": "in", "since": "s", "phase": "of the amplitude"}
KINDS = ("delay", "gap", "wind", "both")
"""Old force kept for a while; play alone; wind-up alone; play and wind-up."""
STARTS = {"stroke": 0.1, "since": 0.03, "phase": 0.1}
"""Starting sizes for the fits, in the coordinate's unit; several multiples are tried."""
GRID = 41
"""Sizes on a grid, and again between two of them, where the force jumps with the size."""


@dataclass(frozen=True, slots=True)
class Path:
    """A candidate with its sizes: friction mu [kip/lb], gap and wind-up in the coordinate's unit, exponent of (u)."""

    kind: str
    coordinate: str
    friction: float
    gap: float = 0.0
    wind: float = 0.0
    power: float = 0.6

    @property
    def name(self) -> str:
        """Name for tables."""
        return "twin" if self.kind == "twin" else f"{self.kind} in {self.coordinate}"


def share(path: Path, data: Samples, reference: float) -> FloatArray:
    """Return the force over friction times `reference` [lb], positive along the motion."""
    way = getattr(data, path.coordinate)
    old, new = data.before / reference, data.now / reference
    if path.kind == "twin":
        return new
    if path.kind == "delay":
        return np.where(way < path.gap, -old, new)
    if path.kind == "gap":
        return np.where(way < path.gap, 0.0, new)
    wind = max(path.wind, 1e-9)
    given = wind * old**path.power
    back = np.maximum(given - way, 0.0) / wind
    again = np.maximum(way - given - path.gap, 0.0) / wind
    return np.asarray(np.minimum(again ** (1.0 / path.power), new) - back ** (1.0 / path.power))


def averaged(values: FloatArray, cell: FloatArray) -> FloatArray:
    """Return the means of the cells."""
    return np.asarray(np.bincount(cell, values) / np.bincount(cell))


def fitted(kind: str, coordinate: str, data: Samples, start: Path | None = None) -> Path:
    """Return the candidate with the sizes that fit the cells best, each test weighed by its own friction level."""
    reference = float(np.median(data.now))
    cell = data.cell
    weight = 1.0 / averaged(data.now, cell)
    force = averaged(data.force * data.half, cell)

    def left(sizes: FloatArray) -> FloatArray:
        model = averaged(share(path_at(kind, coordinate, sizes), data, reference), cell) * reference
        friction = (model * weight) @ (force * weight) / max(float((model * weight) @ (model * weight)), 1e-30)
        return np.asarray((force - friction * model) * weight)

    sizes = searched(left, kind, coordinate, data, start)
    path = path_at(kind, coordinate, sizes)
    model = averaged(share(path, data, reference), cell) * reference
    friction = (model * weight) @ (force * weight) / max(float((model * weight) @ (model * weight)), 1e-30)
    return path_at(kind, coordinate, sizes, float(friction))


def searched(
    left: Callable[[FloatArray], FloatArray], kind: str, coordinate: str, data: Samples, start: Path | None
) -> FloatArray:
    """Return the sizes that leave least: on a grid where the force jumps, from several starts where it does not."""
    low, high = bounds(kind, data, coordinate)
    if not len(low):
        return low
    if len(low) == 1:
        grid = np.linspace(low, 0.5 * high, GRID)
        middle = grid[int(np.argmin([float(np.sum(left(size) ** 2)) for size in grid]))]
        finer = middle + np.linspace(-1.0, 1.0, GRID)[:, None] * (grid[1] - grid[0])
        return np.asarray(finer[int(np.argmin([float(np.sum(left(size) ** 2)) for size in finer]))])
    tries = [sizes_of(start)] if start is not None else [m * first(kind, coordinate) for m in (0.5, 1.0, 2.0)]
    inside = [np.clip(guess, low + 1e-6 * (high - low), high - 1e-6 * (high - low)) for guess in tries]
    found = [
        least_squares(left, guess, bounds=(low, high), x_scale=guess, diff_step=np.full(len(low), 1e-3), xtol=1e-6)
        for guess in inside
    ]
    return np.asarray(min(found, key=lambda one: float(one.cost)).x)


def first(kind: str, coordinate: str) -> FloatArray:
    """Return starting sizes."""
    size = STARTS[coordinate]
    return np.array([2.0 * size, 1.0] if kind == "wind" else [size, size, 0.7])


def bounds(kind: str, data: Samples, coordinate: str) -> tuple[FloatArray, FloatArray]:
    """Return bounds of the sizes: nothing to the longest way, exponents .2 to 2."""
    longest = float(np.quantile(getattr(data, coordinate), 0.99))
    n = {"twin": 0, "delay": 1, "gap": 1, "wind": 1}.get(kind, 2)
    powers = [[0.2], [2.0]] if kind in ("wind", "both") else [[], []]
    return np.array([0.0] * n + powers[0]), np.array([longest] * n + powers[1])


def path_at(kind: str, coordinate: str, sizes: FloatArray, friction: float = 1.0) -> Path:
    """Return the candidate with given sizes."""
    values = [float(size) for size in sizes]
    if kind == "wind":
        return Path(kind, coordinate, friction, 0.0, *values)
    return Path(kind, coordinate, friction, *values)


def sizes_of(path: Path) -> FloatArray:
    """Return the sizes as `fitted` varies them."""
    sizes = {"twin": [], "delay": [path.gap], "gap": [path.gap], "wind": [path.wind, path.power]}
    return np.array(sizes.get(path.kind, [path.gap, path.wind, path.power]))
