"""Planform as manufactured: the wing that was built is a little shorter and narrower than the one that was designed.

Full model: the same grid, materials, regions, gauges (at the same span and chord fractions) and total lift on the
measured outline. The signature is the difference of the two wings' strains; sizes between and beyond are linear, the
chords being within 0.6 % of each other.
Source: the geometry table of the public calibration data of Kapteyn, Pretorius & Willcox (manufactured: length 1828.0,
root chord 433.0, tip chord 260.0 mm).
"""

from collections.abc import Mapping
from functools import cache

from femlib.arrays import FloatArray
from femlib.geometry import Planform
from femlib.wing.effects.card import WingEffect
from femlib.wing.effects.response import Response
from femlib.wing.model import Wing, reshaped
from femlib.wing.planform import PLANFORM

MANUFACTURED = Planform(span=1.828, root_chord=0.433, tip_chord=0.260, spar_fraction=PLANFORM.spar_fraction)


def effect(response: Response) -> WingEffect:
    """Return the effect."""

    @cache  # made at the first call: four seconds that many users of the wing never need
    def built() -> Response:
        return Response(manufactured_wing(response.wing))

    def strains(state: Mapping[str, float], load_factor: float, place: str, time: float) -> FloatArray:
        return load_factor * (built().lift_strains(state) - response.lift_strains(state))

    return WingEffect(
        name="planform",
        parameter="share of the way from the designed to the manufactured planform",
        unit="-",
        prior_sd=1.0,
        prior_source="the published measurement of the built wing is 1; another wing of the mould may differ as much",
        separated_by="strain proportional to load hardly separates it from a modulus; a tape measure does",
        words="manufactured planform",
        action="give the twin the planform that was manufactured",
        says=(
            "the wing is {size} of the way from the designed planform to that one",
            "the wing is {size} of the way beyond the designed planform, on its other side",
        ),
        seen_by=("deflection", "frequency"),
        load_power=1,
        strains=strains,
    )


def manufactured_wing(wing: Wing) -> Wing:
    """Return the wing on the manufactured planform, under the same nodal lift."""
    return reshaped(wing, MANUFACTURED)
