"""Load factors at which plies fail on a coarse mesh, turned into those of fine ones, damage region by region.

Strains at a region's edge converge slowly, and one mesh that is close at the edges of all regions is too large. A zone
is a region with its edge; what belongs to none is one more. Of zone z, with n the reciprocal of its least load factor,

    n_z(state) = n_z,coarse(state) g_z(mu_z),   g_z = n_z,limit / n_z,coarse   where region z alone is damaged:

other damage changes the load of a zone, and hardly the shape of its strains. The limit is that of two meshes that are
close at this region alone, by steps of h and h / 2: strains beside a singular corner converge by the first order, so
that n_limit = 2 n_h/2 - n_h.

Source of the last: P. J. Roache, J. Fluids Eng. 116 (1994) 405-413, eq. 2 with r = 2 and p = 1.
"""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from femlib.arrays import FloatArray, IntArray
from femlib.assembly.stresses import Block, corner_elements
from femlib.components import DamagedStructure

LEVELS = (0.0, 0.2, 0.4, 0.6, 0.7, 0.8, 0.85, 0.9, 0.95)
"""Damages at which the ratios are taken; linear between, constant beyond."""

LEFT = 0.5
"""Share of what extrapolation adds that may still be missing: a third mesh, cut again, left 0.3 of it at region R1."""
AWAY = 1.5
"""A zone that alone never comes nearer than this to the sound structure's limit keeps its coarse factors."""


@dataclass(frozen=True, slots=True, eq=False)
class Zones:
    """The zones of a structure.

    Attributes
    ----------
    of_corner : IntArray
        Component of each corner (n_corners,), n_components where there is none.
    growth : FloatArray
        g (n_components + 1, n_levels) at `LEVELS`.
    error : float
        Estimated relative error of the least factors: `LEFT` of the most that extrapolation adds, of single regions.
    """

    of_corner: IntArray
    growth: FloatArray
    error: float

    def grown(self, damage: FloatArray) -> FloatArray:
        """Return g (n_components + 1,) of damages (n_components,)."""
        levels, at = np.array(LEVELS), np.append(damage, 0.0)
        low = np.minimum(np.searchsorted(levels, at, "right") - 1, len(levels) - 2)
        share = np.minimum((at - levels[low]) / (levels[low + 1] - levels[low]), 1.0)
        row = np.arange(len(at))
        return np.asarray(self.growth[row, low] * (1.0 - share) + self.growth[row, low + 1] * share)


def zone_of_corners(structure: DamagedStructure) -> IntArray:
    """Return the component of each corner (n_corners,) by its node; n_components where there is none."""
    mesh = structure.shells.mesh
    corners = np.concatenate([mesh.quads.ravel(), mesh.trias.ravel()])
    element = corner_elements(structure.shells)
    zone = np.full(len(mesh.nodes), len(structure.components))
    for k, component in enumerate(structure.components):
        zone[corners[component.elements[element]]] = k
    return np.asarray(zone[corners])


def zone_needs(blocks: Sequence[Block], strains: FloatArray, criterion: str, zone: IntArray) -> FloatArray:
    """Return the reciprocals (n_zones,) of the zones' least factors from strains (n_corners, 6) at all corners."""
    needs = np.zeros(zone.max() + 1)
    for block in blocks:
        np.maximum.at(needs, zone[block.corners], 1.0 / block.factors(block.strain(strains), criterion))
    return needs


def measured_zones(
    structure: DamagedStructure,
    coarse: Callable[[FloatArray], FloatArray],
    finer: Callable[[int], Iterable[FloatArray]],
) -> Zones:
    """Return the zones with what refined solves make of them.

    Parameters
    ----------
    structure : DamagedStructure
        The coarse one.
    coarse : callable
        From a state (n_components,) to `zone_needs` (n_components + 1,) on the coarse mesh.
    finer : callable
        From a component's number to the same (n_levels, 2) at `LEVELS`, of it and of the rest, on two meshes of that
        component alone, the second with steps of half the size.
    """
    growth, rest, errors = [], [], []
    each = np.eye(len(structure.components))
    sound = coarse(0.0 * each[0])[-1]
    for k, own in enumerate(each):
        needs = np.array([coarse(level * own)[k] for level in LEVELS])
        if AWAY * needs.max() < sound:
            growth.append(np.ones(len(LEVELS)))
            continue
        once, twice = finer(k)
        limit = 2.0 * twice - once
        growth.append(limit[:, 0] / needs)
        rest.append(limit[0, 1] / sound)
        errors.append(LEFT * np.abs(limit.max(axis=1) / twice.max(axis=1) - 1.0).max())
    whole = np.array([*growth, np.full(len(LEVELS), max(rest, default=1.0))])
    return Zones(zone_of_corners(structure), whole, max(errors, default=float("nan")))
