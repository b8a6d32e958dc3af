"""Random warped, skewed and slender panels: no published answer, but that of a finer and straight mesh."""

from collections.abc import Callable

import numpy as np

from benchmarks.shells.case import Case, hold, mapped
from femlib.arrays import FloatArray
from femlib.assembly import line_load, surface_load
from femlib.material import isotropic_plate

RandomShape = Callable[[int, np.random.Generator | None], Case]


def random_shape(rng: np.random.Generator) -> RandomShape:
    """Return a curved panel clamped at one end under a tip force or its weight on n x n elements; it reads the work.

    It is arched and twisted, rises like a saddle, tapers and is swept, is from 1 to 6 times as long as wide and from 20
    to 500 times as thick. With a generator its inner nodes are moved along the surface by up to a fifth of an element.
    """
    length, arch, twist, rise = rng.uniform([1.0, 0.0, 0.0, 0.0], [6.0, 0.3, 0.7, 0.2])
    sweep, taper, thickness = rng.uniform(0.0, 0.7), rng.uniform(0.4, 1.0), 1.0 / rng.uniform(20.0, 500.0)
    by_weight = bool(rng.integers(2))

    def place(u: FloatArray, v: FloatArray) -> FloatArray:
        width, angle = 1.0 - (1.0 - taper) * u, twist * u
        across, up = width * (v - 0.5), arch * (1.0 - 4.0 * (v - 0.5) ** 2) + rise * u * (v - 0.5)
        y, z = across * np.cos(angle) - up * np.sin(angle), across * np.sin(angle) + up * np.cos(angle)
        return np.stack([length * u + sweep * across, y, z], axis=-1)

    def panel(n: int, moved: np.random.Generator | None) -> Case:
        shift = np.zeros((2, n + 1, n + 1))
        if moved is not None:
            shift[:, 1:-1, 1:-1] = moved.uniform(-0.2 / n, 0.2 / n, (2, n - 1, n - 1))
        shells, node = mapped(
            lambda u, v: place(u + shift[0], v + shift[1]), n, n, isotropic_plate(7e10, 0.3, thickness)
        )
        if by_weight:
            load = surface_load(shells.mesh, np.tile([0.0, 0.0, -100.0], (shells.mesh.n_elements, 1)))
        else:
            load = line_load(shells.mesh, node[-1], np.array([0.0, 0.0, 1.0]))
        return Case(shells, node, hold(node[0], "uvwxyz"), load, load, 1.0, "a finer mesh")

    return panel
