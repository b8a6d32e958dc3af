"""Large deflection: the bent wing's lever shortens and its section flattens, so strain leaves its straight line.

letter = word: L load factor, u(L) = L u1 + L^2 u2 + L^3 u3 displacements, K stiffness, g(u) the corotated shells'
forces, f lift. Balance g(u(L)) = L f order by order gives

    K u2 = -even part of g(u1),   K u3 = f - odd part of g(u1 + u2)

(even and odd under u1 -> -u1), two solves with the factors that every effect uses. Strain of the moved shells, taken
at +L and -L, then splits into L^2 and L^3 terms. Size 1 is this theory; a lift that turns with the wing gives another
size. The lever alone (an elastica) gives half of it: the rest is the pressure of the bent skins' forces on their
panels. Price: orders above the third.
Source: W. T. Koiter, On the Stability of Elastic Equilibrium (1945), expansion of equilibrium in the load; L. G.
Brazier, Proc. R. Soc. A 116 (1927) 104-114 (flattening).
"""

from collections.abc import Mapping

import numpy as np

from femlib.arrays import FloatArray
from femlib.assembly import Deflection
from femlib.assembly.deflection import CorotatedShells
from femlib.kept import Kept
from femlib.wing.bent import gauge_strains
from femlib.wing.effects.card import WingEffect
from femlib.wing.effects.response import Response

SMALL_LOAD = 0.02
"""Load factor of the expansion: small, because a cut series strains the membranes by the next power; not so small that
the third power drowns in rounding."""


def powers(response: Response, state: Mapping[str, float]) -> tuple[FloatArray, FloatArray]:
    """Return the coefficients (n_gauges,) of L^2 and L^3 in the gauge strains [microstrain]."""
    wing = response.wing
    shells = CorotatedShells.of(wing.structure.shells, wing.structure.left_in(state))
    h = SMALL_LOAD
    first = h * response.displacements(state)
    even = 0.5 * (shells.forces(Deflection.along(first)) + shells.forces(Deflection.along(-first)))
    second = -response.moved_by(state, even)
    ahead, back = (shells.forces(Deflection.along(sign * first + second)) for sign in (1.0, -1.0))
    third = response.moved_by(state, h * wing.lift - 0.5 * (ahead - back))

    linear = h * response.lift_strains(state)

    def change(sign: float) -> FloatArray:
        moved = Deflection.along(sign * first + second + sign * third)
        return gauge_strains(wing, moved) - sign * linear

    up, down = change(1.0), change(-1.0)
    return (up + down) / (2.0 * h**2), (up - down) / (2.0 * h**3)


def effect(response: Response) -> WingEffect:
    """Return the effect: a sum of two powers of the load."""
    by_state: Kept[tuple[float, ...], tuple[FloatArray, FloatArray]] = Kept()

    def strains(state: Mapping[str, float], load_factor: float, place: str, time: float) -> FloatArray:
        square, cube = by_state.get(response.key(state), lambda: powers(response, state))
        return np.asarray(load_factor**2 * square + load_factor**3 * cube)

    return WingEffect(
        name="large_deflection",
        parameter="geometric nonlinearity, 1 is the theory of a lift that stays vertical",
        unit="-",
        prior_sd=1.0,
        prior_source="the theory gives 1; lift that follows the wing or a swept spar changes it by its own size",
        separated_by="it grows with the second and third power of the load, a scale with the first",
        words="large deflections",
        action="add large deflections to the twin",
        says=(
            "they act {size} times as strongly as in theory",
            "they act {size} times as strongly as in theory, with the sign reversed",
        ),
        seen_by=("deflection",),
        load_power=None,
        strains=strains,
        is_one_sided=True,
        signature_error=0.3,
    )
