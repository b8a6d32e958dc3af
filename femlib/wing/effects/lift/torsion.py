"""Torsion: the resultant of the lift lies aft of the quarter chord (or ahead of it)."""

from collections.abc import Mapping

import numpy as np

from femlib.arrays import FloatArray
from femlib.wing.effects.card import FixedForce, WingEffect
from femlib.wing.effects.lift.shift import moment, moved_lift
from femlib.wing.effects.response import Response


def effect(response: Response) -> WingEffect:
    """Return the effect."""
    wing = response.wing
    grid = wing.grid
    chord = np.zeros(len(wing.structure.shells.mesh.nodes))
    for skin in (grid.upper, grid.lower):
        chord[skin] = grid.chord[None, :]
    shape = moved_lift(wing, chord)
    total = moment(wing, wing.lift, np.ones_like(chord))
    shape = shape * (0.01 * total / moment(wing, shape, chord))

    def force(state: Mapping[str, float], load_factor: float, place: str) -> FloatArray:
        return load_factor * shape

    return FixedForce(
        name="torsion",
        parameter="shift of the lift's resultant aft, in chords",
        unit="% chord",
        prior_sd=5.0,
        prior_source="the centre of pressure of a cambered section moves by some per cent of the chord with the lift",
        separated_by="it changes the two rows of gauges in opposite ways",
        words="place of the lift along the chord",
        action="correct the place of the lift along the chord in the twin",
        says=("the lift acts {size} farther aft", "the lift acts {size} farther forward"),
        load_power=1,
        response=response,
        force=force,
        signature_error=0.5,
    )
