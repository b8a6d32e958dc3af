"""Modes of shells beside their answers: error and estimate of a buckling load and of a frequency.

A cantilever blade under a force across its tip that buckles sideways (A. G. M. Michell, Phil. Mag. 48 (1899) 298: 4.013
(E I G J)^1/2 / L^2), and the lowest frequency of a simply supported cylinder against a fine mesh.
"""

import numpy as np

from benchmarks.shells.case import along_end, cut, hold, mapped
from femlib.assembly import Shells, Supports, buckling_modes, natural_modes
from femlib.material import isotropic_plate

Measured = tuple[float, float]
"""Error of the answer, positive where it is too low, and its estimate."""
YOUNG, POISSON = 70e9, 0.3


def blade(n: int, n_across: int, diagonal: str | None) -> Measured:
    """Return those of the load at which a blade 1 x 0.05 x 0.002 m buckles sideways."""
    length, height, thick = 1.0, 0.05, 0.002
    shells, node = mapped(
        lambda u, v: np.stack([length * u, 0.0 * u, height * (v - 0.5)], axis=-1),
        n,
        n_across,
        isotropic_plate(YOUNG, POISSON, thick),
    )
    load = along_end(shells, node[-1], "w")
    shells = shells if diagonal is None else cut(shells, diagonal)
    supports = Supports.holding(shells.mesh, hold(node[0], "uvwxyz"))
    torsion = height * thick**3 / 3.0 * (1.0 - 0.63 * thick / height)
    bending, shear = YOUNG * height * thick**3 / 12.0, YOUNG / 2.0 / (1.0 + POISSON)
    exact = 4.013 * np.sqrt(bending * shear * torsion) / length**2
    mode = buckling_modes(shells, supports, load, limit=np.finfo(float).max)[0]
    return 1.0 - mode.factor / exact, mode.error


def cylinder(n: int, n_up: int) -> tuple[Shells, Supports]:
    """Return a quarter of a cylinder, radius and height 1 m, 10 mm thick."""
    shells, node = mapped(
        lambda u, v: np.stack([np.cos(0.5 * np.pi * u), np.sin(0.5 * np.pi * u), v], axis=-1),
        n,
        n_up,
        isotropic_plate(YOUNG, POISSON, 0.01, 2700.0),
    )
    held = [hold(node[:, 0], "uvwz"), hold(node[:, -1], "uvz"), hold(node[0], "vxz"), hold(node[-1], "uyz")]
    return shells, Supports.holding(shells.mesh, np.unique(np.concatenate(held)))


def cylinder_frequency(n: int, n_up: int) -> Measured:
    """Return those of its lowest frequency, against a mesh of 48 x 48."""
    found = []
    for mesh, is_refined in (((n, n_up), True), ((48, 48), False)):
        shells, supports = cylinder(*mesh)
        found.append(natural_modes(shells, supports, 1, limit=np.finfo(float).max, is_refined=is_refined)[0])
    return 1.0 - found[0].frequency / found[1].frequency, found[0].error
