"""Large deflection: the wing bends up, its outer part comes inboard, and the lift's lever shortens.

With slope w'(y) and shear V(y) the shortening s' = w'^2 / 2 changes the bending moment by dM/dy = s' V: a distributed
moment w'^2 V / 2 against the lift, applied as pairs of spanwise forces at the spar's edges. Strain then changes with
the load's third power. Size 1 is this theory; a lift that turns with the wing gives another size. Second order in the
slope, straight spar; two codes found -0.2 to -1.5 % of strain at load factor 3.
Source: A. E. H. Love, A Treatise on the Mathematical Theory of Elasticity (1927), article 263 (the elastica), expanded.
"""

from collections.abc import Mapping
from itertools import pairwise

import numpy as np

from femlib.arrays import FloatArray
from femlib.mesh import DOFS_PER_NODE
from femlib.wing.effects.card import WingEffect
from femlib.wing.effects.response import Response


def effect(response: Response) -> WingEffect:
    """Return the effect."""
    wing = response.wing
    grid = wing.grid
    nodes = wing.structure.shells.mesh.nodes
    top, bottom = grid.upper[:, grid.spar_column], grid.lower[:, grid.spar_column]
    y, height = nodes[top, 1], nodes[top, 2] - nodes[bottom, 2]
    lift = wing.lift.reshape(-1, DOFS_PER_NODE)[:, 2]
    shear = np.array([lift[nodes[:, 1] >= 0.5 * (a + b)].sum() for a, b in pairwise(y.tolist())])

    def force(state: Mapping[str, float], load_factor: float, place: str) -> FloatArray:
        rise = response.displacements(state).reshape(-1, DOFS_PER_NODE)[top, 2]
        slope = np.diff(rise) / np.diff(y)
        moment = 0.5 * slope**2 * shear * np.diff(y) * load_factor**3
        push = np.zeros((len(nodes), DOFS_PER_NODE))
        for inner, outer in ((top, 1.0), (bottom, -1.0)):
            for end in (inner[:-1], inner[1:]):
                np.add.at(push[:, 1], end, 0.5 * outer * moment / (0.5 * (height[:-1] + height[1:])))
        return push.ravel()

    return WingEffect(
        name="large_deflection",
        parameter="geometric nonlinearity, 1 is the theory of a shortening lever",
        unit="-",
        prior_sd=1.0,
        prior_source="the theory gives 1; lift that follows the wing or a swept spar changes it by its own size",
        separated_by="it grows with the third power of the load, a scale with the first",
        load_power=3,
        response=response,
        force=force,
        is_one_sided=True,
    )
