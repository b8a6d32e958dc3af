"""Creep: the resin of the skins yields slowly, so under a load the strain grows with time while the load stays.

Under a load that stays, the skins' compliance grows by size * c(t) per cent, c = 1 after one hour: a power of time, or
an exponential that ends. At every moment the wing is an elastic one with softer skins (quasi-elastic),
f = +0.01 c(t) K_skin(mu) u to first order. The answers to
several steps of the load add up, each from its own time on (Boltzmann); what was loaded before the first reading is not
known. Price: the recovery after a load has gone follows the same law.
Source: W. N. Findley, J. S. Lai, K. Onaran, Creep and Relaxation of Nonlinear Viscoelastic Materials (1976), chapter 8
(power law of time); R. A. Schapery, in Mechanics of Composite Materials 2 (1974), section 4 (quasi-elastic method).
"""

import math

from femlib.wing.effects.card import WingEffect
from femlib.wing.effects.response import Response
from femlib.wing.effects.skins import SkinForces

HOUR = 3600.0
EXPONENT = 0.2
"""Power of time of a +-45 carbon fabric in epoxy, whose resin carries the shear. Assumed: plastics creep with 0.1 to
0.3."""
RETARDATION = {"within minutes": 100.0, "within half an hour": 1000.0}
"""Retardation time of one Kelvin element [s]: a decade apart, they tell quick from slow."""
POWER = "as a power of time"


def course(time: float, place: str = POWER) -> float:
    """Return the growth of compliance at `time` [s] over that after one hour; none before the start."""
    if place in RETARDATION:
        return math.expm1(-max(time, 0.0) / RETARDATION[place]) / math.expm1(-HOUR / RETARDATION[place])
    return float((max(time, 0.0) / HOUR) ** EXPONENT)


def effect(response: Response) -> WingEffect:
    """Return the effect, whose places are its courses of time: the true one is none of them, or lies between two."""
    skins = SkinForces.of(response)
    return WingEffect(
        name="creep",
        parameter="growth of the skins' compliance after one hour under load",
        unit="%",
        prior_sd=2.0,
        prior_source="matrix-dominated laminates at room temperature creep by one to five per cent in an hour",
        separated_by="its course of time: the same load again at the end reads more, which a scale does not do",
        words="creep of the skins",
        words_at="creep of the skins {place}",
        action="add the creep of the skins to the twin",
        says=(
            "their compliance grows by {size} in the first hour under load",
            "their compliance falls by {size} in the first hour under load",
        ),
        load_power=1,
        strains=lambda state, load_factor, place, time: course(time, place) * 0.01 * load_factor * skins.strains(state),
        is_one_sided=True,
        uses_time=True,
        superposes=True,
        place_names=(POWER, *RETARDATION),
        n_between=2,
    )
