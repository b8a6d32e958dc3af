"""Strips: straight, curved and twisted beams, Raasch's hook.

Sources: R. H. MacNeal, R. L. Harder, Finite Elements in Analysis and Design 1 (1985) 3-20 (beams); N. F. Knight, AIAA
Journal 35 (1997) 1048-1052 (Raasch's hook; 5.02 is what solid elements give).
"""

import numpy as np

from benchmarks.shells.case import Case, along_end, at, hold, mapped
from femlib.arrays import FloatArray
from femlib.material import isotropic_plate

BEAM_SHAPES = ("rectangular", "trapezoidal", "parallelogram")
MACNEAL = "MacNeal, Harder 1985"


def straight_beam(shape: str, direction: str, n: int = 6, n_across: int = 1) -> Case:
    """Cantilever 6 x 0.2 x 0.1 of n elements under unit tip forces: deflection.

    `direction`: "u" extension, "v" in-plane shear, "w" out-of-plane shear, "x" twist.
    """
    slant = {"rectangular": (0.0, 0.0), "trapezoidal": (1.0, -1.0), "parallelogram": (1.0, 1.0)}[shape]

    def place(u: FloatArray, v: FloatArray) -> FloatArray:
        station = np.round(u * n)
        inner = (station > 0) & (station < n)
        sign = np.where(station % 2 == 1, 1.0, -1.0) if shape == "trapezoidal" else 1.0
        shift = 0.1 * sign * np.where(v > 0.5, slant[0], -1.0 if shape == "parallelogram" else slant[1]) * inner
        return np.stack([6.0 * u + shift, 0.2 * (v - 0.5), 0.0 * u], axis=-1)

    shells, node = mapped(place, n, n_across, isotropic_plate(1e7, 0.3, 0.1))
    below, above = (int(k) for k in node[-1, [0, -1]])
    if direction == "x":  # a couple of 0.5, read as the slope across
        load, read = (at(shells, above, "w", f) - at(shells, below, "w", f) for f in (2.5, 5.0))
    else:
        load = at(shells, above, direction, 0.5) + at(shells, below, direction, 0.5)
        read = load
    exact = {"u": 3e-5, "v": 0.1081, "w": 0.4321, "x": 0.03208 * 0.5}[direction]
    return Case(shells, node, hold(node[0], "uvwxyz"), load, read, exact, MACNEAL)


def curved_beam(direction: str, n: int = 6, n_across: int = 1) -> Case:
    """Quarter ring 4.12 to 4.32, 0.1 thick, under a unit tip force: "u" in its plane, "w" out of it."""

    def place(u: FloatArray, v: FloatArray) -> FloatArray:
        radius, angle = 4.12 + 0.2 * v, 0.5 * np.pi * (1.0 - u)
        return np.stack([radius * np.cos(angle), radius * np.sin(angle), 0.0 * u], axis=-1)

    shells, node = mapped(place, n, n_across, isotropic_plate(1e7, 0.25, 0.1))
    load = at(shells, int(node[-1, 0]), direction, 0.5) + at(shells, int(node[-1, -1]), direction, 0.5)
    read = np.mean([at(shells, int(k), direction) for k in node[-1]], axis=0)
    exact = {"u": 0.08734, "w": 0.5022}[direction]
    return Case(shells, node, hold(node[0], "uvwxyz"), load, read, exact, MACNEAL)


def twisted_beam(thickness: float, direction: str, n: int = 12, n_across: int = 2) -> Case:
    """Strip 12 x 1.1 twisted by 90 degrees under a unit tip force along "v" or "w"."""

    def place(u: FloatArray, v: FloatArray) -> FloatArray:
        angle, across = 0.5 * np.pi * u, 1.1 * (v - 0.5)
        return np.stack([12.0 * u, across * np.cos(angle), across * np.sin(angle)], axis=-1)

    shells, node = mapped(place, n, n_across, isotropic_plate(29e6, 0.22, thickness))
    exact = {(0.32, "v"): 1.754e-3, (0.32, "w"): 5.424e-3, (0.0032, "v"): 1296.0, (0.0032, "w"): 5256.0}
    load = along_end(shells, node[-1], direction)
    return Case(shells, node, hold(node[0], "uvwxyz"), load, load, exact[thickness, direction], MACNEAL)


def raasch_hook(n: int = 36, n_across: int = 5) -> Case:
    """Strip of two arcs, radii 14 and 46, 20 wide, under a unit shear force across its end."""

    def place(u: FloatArray, v: FloatArray) -> FloatArray:
        first, second = 14.0 * np.pi / 3.0, 46.0 * np.radians(150.0)
        along = u * (first + second)
        one, other = along / 14.0, np.pi / 3.0 + np.pi - (along - first) / 46.0
        middle = 60.0 * np.array([np.sin(np.pi / 3.0), np.cos(np.pi / 3.0)])
        x = np.where(along < first, 14.0 * np.sin(one), middle[0] + 46.0 * np.sin(other))
        y = np.where(along < first, 14.0 * np.cos(one), middle[1] + 46.0 * np.cos(other))
        return np.stack([x, y, 20.0 * v], axis=-1)

    shells, node = mapped(place, n, n_across, isotropic_plate(3300.0, 0.35, 2.0))
    load = along_end(shells, node[-1], "w")
    return Case(shells, node, hold(node[0], "uvwxyz"), load, load, 5.02, "Knight 1997, solid elements")
