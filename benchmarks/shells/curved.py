"""Curved shells: Scordelis-Lo roof, pinched cylinder, pinched hemisphere.

Sources: R. H. MacNeal, R. L. Harder, Finite Elements in Analysis and Design 1 (1985) 3-20 (roof, hemisphere with a hole
of 18 degrees); T. Belytschko et al., Comput. Methods Appl. Mech. Engng 51 (1985) 221-258 (cylinder).
"""

import numpy as np

from benchmarks.shells.case import Case, at, hold, mapped
from femlib.arrays import FloatArray
from femlib.assembly import surface_load
from femlib.material import isotropic_plate

SLANT = 0.3
"""Share of the roof's width by which mesh lines lean across it, so that its elements are warped."""


def scordelis_lo_roof(n: int, slant: float = 0.0) -> Case:
    """Quarter of a roof under its weight: deflection of the free edge's middle."""

    def place(u: FloatArray, v: FloatArray) -> FloatArray:
        angle = np.radians(40.0) * (u + slant * np.sin(np.pi * u) * (v - 0.5))
        return np.stack([25.0 * np.sin(angle), 25.0 * v, 25.0 * np.cos(angle)], axis=-1)

    shells, node = mapped(place, n, n, isotropic_plate(4.32e8, 0.0, 0.25))
    weight = np.tile([0.0, 0.0, -90.0], (shells.mesh.n_elements, 1))
    # y = 0 is the middle, y = 25 the diaphragm; x = 0 the crown
    held = np.concatenate([hold(node[:, -1], "uw"), hold(node[:, 0], "vxz"), hold(node[0], "uyz")])
    read = at(shells, int(node[-1, 0]), "w", -1.0)
    return Case(shells, node, held, surface_load(shells.mesh, weight), read, 0.3024, "MacNeal, Harder 1985")


def pinched_cylinder(n: int) -> Case:
    """Eighth of a cylinder with end diaphragms under two opposite forces: deflection under one."""

    def place(u: FloatArray, v: FloatArray) -> FloatArray:
        angle = 0.5 * np.pi * u
        return np.stack([300.0 * np.sin(angle), 300.0 * v, 300.0 * np.cos(angle)], axis=-1)

    shells, node = mapped(place, n, n, isotropic_plate(3e6, 0.3, 3.0))
    held = [hold(node[:, -1], "uw"), hold(node[:, 0], "vxz"), hold(node[0], "uyz"), hold(node[-1], "wxy")]
    load, read = (at(shells, int(node[0, 0]), "w", size) for size in (-0.25, -1.0))
    return Case(shells, node, np.concatenate(held), load, read, 1.8248e-5, "Belytschko 1985")


def pinched_hemisphere(n: int) -> Case:
    """Quarter of a hemisphere with a hole of 18 degrees under four forces of 2: deflection under one."""

    def place(u: FloatArray, v: FloatArray) -> FloatArray:
        around, up = 0.5 * np.pi * u, np.radians(72.0) * v
        return 10.0 * np.stack([np.cos(up) * np.cos(around), np.cos(up) * np.sin(around), np.sin(up)], axis=-1)

    shells, node = mapped(place, n, n, isotropic_plate(6.825e7, 0.3, 0.04))
    read = at(shells, int(node[0, 0]), "u")
    load = read + at(shells, int(node[-1, 0]), "v", -1.0)
    held = np.concatenate([hold(node[0], "vxz"), hold(node[-1], "uyz"), hold(node[:1, :1], "w")])
    return Case(shells, node, held, load, read, 0.093, "MacNeal, Harder 1985")
