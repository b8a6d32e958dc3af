"""Global modulus: all materials stiffer or softer by one factor. Exact: strain goes with 1 / (1 + size / 100)."""

from collections.abc import Mapping
from typing import Any

from femlib.arrays import FloatArray
from femlib.wing.effects.card import WingEffect, strains_of
from femlib.wing.effects.response import Response


class Modulus(WingEffect):
    """The effect, with its exact forward map."""

    __slots__ = ()

    def predict(
        self, twin: Any, state: Mapping[str, float], load_factor: float, size: float, place: str, time: float
    ) -> FloatArray:
        """Return the strains (n_gauges,) of a wing whose moduli are 1 + size / 100 times the model's."""
        strain: FloatArray = twin.predict(state, load_factor)
        return strain / (1.0 + 0.01 * size)


def effect(response: Response) -> WingEffect:
    """Return the effect."""
    force = -0.01 * response.wing.lift  # K / (1 + s) under the lift is K under lift / (1 + s)
    return Modulus(
        name="modulus",
        parameter="change of all moduli",
        unit="%",
        bounds=(-90.0, 300.0),
        prior_sd=2.0,
        prior_source="moduli of hand-laid fabric and plywood scatter by some per cent between batches",
        separated_by="strain cannot separate it from the load factor or a common gain; deflection or frequency does",
        words="modulus of the whole wing",
        action="correct the modulus of the whole wing in the twin",
        says=("the wing is {size} stiffer than the twin", "the wing is {size} softer than the twin"),
        seen_by=("deflection", "frequency"),
        load_power=1,
        strains=strains_of(response, "modulus", lambda place: force),
        signature_error=0.0,  # exact: strain goes with the modulus whatever the model
    )
