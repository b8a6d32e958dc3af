"""Aerodynamic loads as nodal forces.

Elliptic lift over the half-span b: l(y) = 4 P / (pi b) sqrt(1 - (y / b)^2), P = L W g / 2. Over the chord the pressure
is 3 (1 - x/c)^2, whose resultant lies at the quarter chord.
"""

from collections.abc import Callable

import numpy as np

from femlib.arrays import FloatArray
from femlib.mesh import DOFS_PER_NODE
from femlib.wing.structure import WingGrid

GRAVITY = 9.81
"""Standard gravity as the published test loads use it [m/s^2]."""
EFFECTIVE_MASS = 32.357
"""Mass of the aircraft that the whole wing carries at load factor 1 [kg]. Fitted: with the published tip stiffness
0.677 N/mm the published strains ask for it."""
TAPERED_MASS = 25.0
"""The same of `tapered_wing`."""


def elliptic_lift(grid: WingGrid, effective_mass: float = EFFECTIVE_MASS) -> FloatArray:
    """Return nodal forces (n_dofs,) [N] of the half wing at load factor 1.

    The lift of each cell of the grid is lumped to its lines exactly (by the integrals of the two distributions), half
    to each skin, and the chordwise lumps are linear between the lines so that the resultant stays at the quarter chord.
    """
    total = effective_mass * GRAVITY / 2.0
    along = _lumped(grid.eta, _ellipse_integral, _ellipse_moment)
    across = _lumped(grid.chord, _pressure_integral, _pressure_moment)
    force = 0.5 * total * np.outer(along, across)
    loads = np.zeros(DOFS_PER_NODE * grid.n_nodes)
    for nodes in (grid.upper, grid.lower):
        np.add.at(loads, DOFS_PER_NODE * nodes + 2, force)
    return loads


_Primitive = Callable[[FloatArray], FloatArray]


def _lumped(lines: FloatArray, integral: _Primitive, moment: _Primitive) -> FloatArray:
    """Share a distribution among lines; each cell keeps its force and its first moment exactly."""
    a, b = lines[:-1], lines[1:]
    force = integral(b) - integral(a)
    outer = (moment(b) - moment(a) - a * force) / (b - a)
    shares = np.zeros(len(lines))
    shares[:-1] += force - outer
    shares[1:] += outer
    return shares


def _ellipse_integral(t: FloatArray) -> FloatArray:
    return (2.0 / np.pi) * (t * np.sqrt(np.maximum(0.0, 1.0 - t * t)) + np.arcsin(np.clip(t, -1.0, 1.0)))


def _ellipse_moment(t: FloatArray) -> FloatArray:
    return -(4.0 / (3.0 * np.pi)) * np.maximum(0.0, 1.0 - t * t) ** 1.5


def _pressure_integral(x: FloatArray) -> FloatArray:
    return 1.0 - (1.0 - x) ** 3


def _pressure_moment(x: FloatArray) -> FloatArray:
    return 1.5 * x**2 - 2.0 * x**3 + 0.75 * x**4
