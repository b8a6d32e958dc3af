"""Load factors at which plies fail on a coarse mesh, turned into those of fine ones, damage region by region.

Strains at a region's edge converge slowly, and one mesh that is close at the edges of all regions is too large. A zone
is a quarter of a region with its edge, so that each corner has its own; what belongs to no region is one more. Of zone
z of region k, with n the reciprocal of its least load factor,

    n_z(state) = n_z,coarse(state) g_z(mu_k),   g_z = n_z,limit / n_z,coarse   where region k alone is damaged:

other damage changes the load of a zone, and hardly the shape of its strains. What belongs to no region grows by what it
does on the sound structure times, for each region, what that region's damage changes in it. The limit is that of two
meshes that are close at this region alone, by steps of h and h / 2: strains beside a singular corner converge by the
first order, so that n_limit = 2 n_h/2 - n_h.

Two damaged regions are more than the formula knows. The pairs that change each other most on the coarse mesh are solved
on two meshes close at both, and the error is the farthest that the formula is off from these limits.

Source of the limit: P. J. Roache, J. Fluids Eng. 116 (1994) 405-413, eq. 2 with r = 2 and p = 1.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np
from scipy.interpolate import PchipInterpolator

from femlib.arrays import FloatArray, IntArray
from femlib.assembly.stresses import Block, corner_elements
from femlib.components import DamagedStructure
from femlib.mesh import Mesh

LEVELS = (0.0, 0.2, 0.4, 0.6, 0.7, 0.8, 0.85, 0.9, 0.95)
"""Damages at which the ratios are taken; monotone cubics between, constant beyond."""
STEP = 0.01
"""Of the table of those cubics, which is read by lines."""
QUARTERS = 4
BOTH = ((0.8, 0.8), (0.3, 0.9), (0.88, 0.65))
"""Damages of a pair of regions at which the error is measured; the first tells which pairs to take."""
N_PAIRS = 3
"""Pairs that are measured."""
LEFT = 0.5
"""Share of what extrapolation adds that may still be missing: a third mesh, cut again, left 0.3 of it at region R1."""
AWAY = 1.5
"""A zone that alone never comes nearer than this to the sound structure's limit keeps its coarse factors."""

Finer = Callable[[tuple[int, ...], FloatArray], Sequence[FloatArray]]
"""From components and their damages (n_states, n_components) to `zone_needs` (n_states, n_zones) of a structure with
these alone, on two meshes close at them, the second with steps of half the size."""


@dataclass(frozen=True, slots=True, eq=False)
class Zones:
    """The zones of a structure.

    Attributes
    ----------
    of_corner : IntArray
        Zone of each corner (n_corners,): quarters of the first component, of the second, the rest.
    growth : FloatArray
        (n_components, QUARTERS + 1, n) at damages in steps of `STEP`: g of each quarter, and the factor on the rest's.
    rest : float
        g of what belongs to no component, where nothing is damaged.
    error : float
        Estimated relative error of the least factors: `LEFT` of the most that extrapolation adds, or the most that the
        measured pairs are off, if that is more.
    """

    of_corner: IntArray
    growth: FloatArray
    rest: float
    error: float

    def grown(self, damage: FloatArray) -> FloatArray:
        """Return g (n_zones,) of damages (n_components,)."""
        place = np.minimum(damage / STEP, self.growth.shape[2] - 1.0)
        low = np.minimum(place.astype(np.intp), self.growth.shape[2] - 2)
        share, row = (place - low)[:, None], np.arange(len(damage))
        factors = self.growth[row, :, low] * (1.0 - share) + self.growth[row, :, low + 1] * share
        return np.append(factors[:, :QUARTERS].ravel(), self.rest * factors[:, QUARTERS].prod())


def zone_of_corners(structure: DamagedStructure) -> IntArray:
    """Return the zone of each corner (n_corners,) by its node, as `Zones.of_corner`."""
    mesh = structure.shells.mesh
    corners = np.concatenate([mesh.quads.ravel(), mesh.trias.ravel()])
    element = corner_elements(structure.shells)
    zone = np.full(len(mesh.nodes), QUARTERS * len(structure.components))
    for k, component in enumerate(structure.components):
        nodes = np.unique(corners[component.elements[element]])
        zone[nodes] = QUARTERS * k + _quarter(mesh, nodes)
    return np.asarray(zone[corners])


def _quarter(mesh: Mesh, nodes: IntArray) -> IntArray:
    """Return the quarter of each node (n,) of a box about them, cut in the middles of its two longest sides."""
    places = mesh.nodes[nodes]
    longest = np.sort(np.argsort(-np.ptp(places, axis=0), kind="stable")[:2])
    middle = 0.5 * (places.min(axis=0) + places.max(axis=0))
    is_beyond = (places > middle)[:, longest]
    return np.asarray(2 * is_beyond[:, 0] + is_beyond[:, 1])


def zone_needs(blocks: Sequence[Block], strains: FloatArray, criterion: str, zone: IntArray) -> FloatArray:
    """Return the reciprocals (n_zones,) of the zones' least factors from strains (n_corners, 6) at all corners."""
    needs = np.zeros(zone.max() + 1)
    for block in blocks:
        np.maximum.at(needs, zone[block.corners], 1.0 / block.factors(block.strain(strains), criterion))
    return needs


def measured_zones(structure: DamagedStructure, coarse: Callable[[FloatArray], FloatArray], finer: Finer) -> Zones:
    """Return the zones with what refined solves make of them.

    Parameters
    ----------
    structure : DamagedStructure
        The coarse one.
    coarse : callable
        From a state (n_components,) to `zone_needs` (n_zones,) on the coarse mesh.
    finer : Finer
        Solves on finer meshes.
    """
    each = np.eye(len(structure.components))
    sound, levels = coarse(0.0 * each[0])[-1], np.array(LEVELS)
    growth, rests, errors, near = np.ones((len(each), QUARTERS + 1, len(LEVELS))), [], [], []
    for k, own in enumerate(each):
        needs = np.array([coarse(level * own) for level in LEVELS])
        quarters = slice(QUARTERS * k, QUARTERS * (k + 1))
        if AWAY * needs[:, quarters].max() < sound:
            continue
        near.append(k)
        once, twice = finer((k,), levels[:, None])
        limit = 2.0 * twice - once
        growth[k, :QUARTERS] = (limit[:, :QUARTERS] / needs[:, quarters]).T
        rest = _growth_of_rest(limit[:, QUARTERS], np.delete(needs, quarters, axis=1))
        growth[k, QUARTERS] = rest / rest[0]
        rests.append(rest[0])
        errors.append(LEFT * np.abs(limit.max(axis=1) / twice.max(axis=1) - 1.0).max())
    steps = np.linspace(0.0, LEVELS[-1], round(LEVELS[-1] / STEP) + 1)
    table = PchipInterpolator(levels, growth, axis=2)(steps)
    zones = Zones(zone_of_corners(structure), table, max(rests, default=1.0), float("nan"))
    pairs = [np.abs(off).max() for off in _pairs_off(zones, coarse, finer, near)]
    return Zones(zones.of_corner, table, zones.rest, max([*errors, *pairs], default=float("nan")))


def _growth_of_rest(limit: FloatArray, needs: FloatArray) -> FloatArray:
    """Return the growth (n_levels,) of what belongs to no component, the last of `needs` (n_levels, n_others).

    The limits hold for all other zones together, so where another needs most the growth stays as it was.
    """
    growth = limit / needs.max(axis=1)
    for level in np.flatnonzero(needs.argmax(axis=1) < needs.shape[1] - 1):
        growth[level] = growth[level - 1] if level else 1.0
    return np.asarray(growth)


def _pairs_off(
    zones: Zones, coarse: Callable[[FloatArray], FloatArray], finer: Finer, near: Sequence[int]
) -> list[FloatArray]:
    """Return how far the zones are off in the pairs of components that change each other most, each (n_states,)."""
    each = np.eye(len(zones.growth))
    alone = {k: coarse(BOTH[0][0] * each[k]).max() for k in near}
    change = {
        (i, k): abs(coarse(np.array(BOTH[0]) @ each[[i, k]]).max() / max(alone[i], alone[k]) - 1.0)
        for i, k in combinations(near, 2)
    }
    off = []
    for pair in sorted(change, key=lambda pair: -change[pair])[:N_PAIRS]:
        once, twice = finer(pair, np.array(BOTH))
        states = np.array(BOTH) @ each[list(pair)]
        needs = [(coarse(state) * zones.grown(state)).max() for state in states]
        off.append(needs / (2.0 * twice - once).max(axis=1) - 1.0)
    return off
