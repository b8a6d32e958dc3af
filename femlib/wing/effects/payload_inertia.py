"""Inertial relief: a mass in the wing that the model does not have pulls down with the load factor."""

import numpy as np

from femlib.arrays import FloatArray
from femlib.wing.effects.card import WingEffect, strains_of
from femlib.wing.effects.response import Response
from femlib.wing.inertia import unit_weight

STATIONS = tuple(float(eta) for eta in np.linspace(0.3, 1.0, 15).round(2))
"""Span fractions at which the mass may sit, on the spar."""


def effect(response: Response) -> WingEffect:
    """Return the effect."""

    def force(place: str) -> FloatArray:
        return unit_weight(response.wing, float(place.removeprefix("eta ")))

    return WingEffect(
        name="payload_inertia",
        parameter="mass in the wing that the model does not have",
        unit="kg",
        prior_sd=0.3,
        prior_source="servos, pitot and fuel of this wing weigh a tenth to half a kilogram each",
        separated_by="strains outboard of the mass do not change",
        words="mass in the wing",
        words_at="mass in the wing at {place}",
        action="correct the mass of the wing at {place} in the twin",
        says=("the wing holds {size} more than the twin there", "the wing holds {size} less than the twin there"),
        seen_by=("frequency",),
        load_power=1,
        strains=strains_of(response, "payload_inertia", force),
        place_names=tuple(f"eta {eta:g}" for eta in STATIONS),
        n_between=2,
        is_one_sided=True,
    )
