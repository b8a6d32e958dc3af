"""Effects of the lift at its same total: carried further outboard than the ellipse, or further aft along the chord.

Distribution along the span: letter = word: theta with cos theta = y / span, A_n coefficients of the lifting line's
circulation sum A_n sin(n theta) over odd n. A_1 alone is the ellipse and holds the total lift; A_3, A_5 and A_7 change
where it acts. The size is the change of the bending moment at the root, a place the shares of the fifth and the seventh
harmonic in it.
Price: the ninth harmonic and beyond.
Source: H. Glauert, The Elements of Aerofoil and Airscrew Theory (1926), chapter 11.
"""

from collections.abc import Mapping
from itertools import product

import numpy as np

from femlib.arrays import FloatArray
from femlib.mesh import DOFS_PER_NODE
from femlib.wing.effects.card import FixedForce, WingEffect
from femlib.wing.effects.response import Response
from femlib.wing.model import Wing
from femlib.wing.trim import harmonic_lift, moved_lift

FIFTH_SHARES = (-0.6, -0.4, -0.2, 0.0, 0.2, 0.4)
SEVENTH_SHARES = (-0.06, 0.0, 0.06)


def lift_distribution(response: Response) -> WingEffect:
    """Return the effect of another distribution of the lift along the span."""
    third, fifth, seventh = (_harmonic(response, order) for order in (3, 5, 7))
    shapes = {
        f"shares of harmonics 5 and 7: {a:g} and {b:g}": (1.0 - a - b) * third + a * fifth + b * seventh
        for a, b in product(FIFTH_SHARES, SEVENTH_SHARES)
    }

    def force(state: Mapping[str, float], load_factor: float, place: str) -> FloatArray:
        return load_factor * shapes[place]

    return WingEffect(
        name="lift_distribution",
        parameter="change of the root bending moment at the same total lift",
        unit="%",
        prior_sd=4.0,
        prior_source="a vortex lattice carries 7 to 28 % more bending moment outboard than the ellipse",
        separated_by="it changes the strains outboard more than inboard, a scale changes all alike",
        words="distribution of the lift along the span",
        words_at="distribution of the lift along the span",
        action="correct the distribution of the lift along the span in the twin",
        says=(
            "the bending moment at the root is {size} larger at the same lift",
            "the bending moment at the root is {size} smaller at the same lift",
        ),
        load_power=1,
        response=response,
        force=force,
        place_names=tuple(shapes),
        n_between=4,
    )


def _harmonic(response: Response, order: int) -> FloatArray:
    """Return nodal forces (n_dofs,) [N] of a harmonic that changes the root's bending moment by one per cent."""
    wing = response.wing
    eta = wing.structure.shells.mesh.nodes[:, 1] / wing.span
    shape = harmonic_lift(wing, order)
    return np.asarray(shape * (0.01 * moment(wing, wing.lift, eta) / moment(wing, shape, eta)))


def torsion(response: Response) -> WingEffect:
    """Return the effect of a resultant aft of the quarter chord, or ahead of it."""
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


def moment(wing: Wing, force: FloatArray, place: FloatArray) -> float:
    """Return sum of vertical force times coordinate."""
    return float(force.reshape(-1, DOFS_PER_NODE)[:, 2] @ place)
