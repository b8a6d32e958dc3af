"""Effects that a real wing may have and the model lacks: one line here for each."""

from collections.abc import Mapping

from femlib.wing.effects import (
    creep,
    damage_outside_library,
    large_deflection,
    lift,
    modulus,
    payload_inertia,
    planform,
    root_flexibility,
    skins,
    spar_skin_debond,
    thermal,
)
from femlib.wing.effects.card import WingEffect
from femlib.wing.effects.response import Response
from femlib.wing.model import Wing

EFFECTS = (
    modulus.effect,
    skins.skin_thickness,
    thermal.temperature_uniform,
    thermal.temperature_gradient,
    lift.lift_distribution,
    lift.torsion,
    large_deflection.effect,
    payload_inertia.effect,
    damage_outside_library.effect,
    spar_skin_debond.effect,
    creep.effect,
    planform.effect,
    root_flexibility.effect,
)


def wing_effects(wing: Wing) -> Mapping[str, WingEffect]:
    """Return the effects of a wing by name."""
    response = Response(wing)
    found = [make(response) for make in EFFECTS]
    return {effect.name: effect for effect in found}


__all__ = ["WingEffect", "wing_effects"]
