"""Lift distribution: the same total lift, carried further outboard than the ellipse.

letter = word: theta with cos theta = y / span, A_n coefficients of the lifting line's circulation sum A_n sin(n theta)
over odd n. A_1 alone is the ellipse and holds the total lift; A_3, A_5 and A_7 change where it acts. The size is the
change of the bending moment at the root, a place the shares of the fifth and the seventh harmonic in it.
Price: the ninth harmonic and beyond.
Source: H. Glauert, The Elements of Aerofoil and Airscrew Theory (1926), chapter 11.
"""

from collections.abc import Mapping
from itertools import product

import numpy as np

from femlib.arrays import FloatArray
from femlib.wing.effects.card import WingEffect
from femlib.wing.effects.lift.shift import moment, moved_lift
from femlib.wing.effects.response import Response

FIFTH_SHARES = (-0.6, -0.4, -0.2, 0.0, 0.2, 0.4)
SEVENTH_SHARES = (-0.06, 0.0, 0.06)


def effect(response: Response) -> WingEffect:
    """Return the effect."""
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
    theta = np.arccos(np.clip(eta, 0.0, 1.0))
    shape = moved_lift(wing, np.sin(order * theta) / np.maximum(np.sin(theta), 1e-6))
    return np.asarray(shape * (0.01 * moment(wing, wing.lift, eta) / moment(wing, shape, eta)))
