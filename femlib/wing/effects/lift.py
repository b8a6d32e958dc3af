"""Effects of the lift at its same total: carried further outboard than the ellipse, or further aft along the chord.

Distribution along the span: letter = word: theta with cos theta = y / span, A_n coefficients of the lifting line's
circulation sum A_n sin(n theta) over odd n. A_1 alone is the ellipse and holds the total lift; A_3, A_5 and A_7 change
where it acts. The size is the change of the bending moment at the root, a place the shares of the fifth and the seventh
harmonic in it.
Price: the ninth harmonic and beyond.
Source: H. Glauert, The Elements of Aerofoil and Airscrew Theory (1926), chapter 11.
"""

from itertools import product

import numpy as np

from femlib.arrays import FloatArray
from femlib.mesh import DOFS_PER_NODE
from femlib.wing.effects.card import WingEffect, strains_of
from femlib.wing.effects.response import Response
from femlib.wing.model import Wing

FIFTH_SHARES = (-0.6, -0.4, -0.2, 0.0, 0.2, 0.4)
SEVENTH_SHARES = (-0.06, 0.0, 0.06)


def lift_distribution(response: Response) -> WingEffect:
    """Return the effect of another distribution of the lift along the span."""
    shapes = distributions(response.wing)
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
        strains=strains_of(response, "lift_distribution", shapes.__getitem__),
        place_names=tuple(shapes),
        n_between=4,
    )


def distributions(wing: Wing) -> dict[str, FloatArray]:
    """Return nodal forces (n_dofs,) [N] of distributions that change the root's bending moment by one per cent."""
    third, fifth, seventh = (_harmonic(wing, order) for order in (3, 5, 7))
    return {
        f"shares of harmonics 5 and 7: {a:g} and {b:g}": (1.0 - a - b) * third + a * fifth + b * seventh
        for a, b in product(FIFTH_SHARES, SEVENTH_SHARES)
    }


def _harmonic(wing: Wing, order: int) -> FloatArray:
    """Return those of an odd harmonic above the first."""
    eta = wing.structure.shells.mesh.nodes[:, 1] / wing.span
    theta = np.arccos(np.clip(eta, 0.0, 1.0))
    shape = moved_lift(wing, np.sin(order * theta) / np.maximum(np.sin(theta), 1e-6))
    return np.asarray(shape * (0.01 * moment(wing, wing.lift, eta) / moment(wing, shape, eta)))


def torsion(response: Response) -> WingEffect:
    """Return the effect of a resultant aft of the quarter chord, or ahead of it."""
    shape = moved_aft(response.wing)
    return WingEffect(
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
        strains=strains_of(response, "torsion", lambda place: shape),
        signature_error=0.5,
    )


def moved_aft(wing: Wing) -> FloatArray:
    """Return nodal forces (n_dofs,) [N] that move the lift's resultant aft by one per cent of the chord."""
    chord = np.zeros(len(wing.structure.shells.mesh.nodes))
    for skin in (wing.grid.upper, wing.grid.lower):
        chord[skin] = wing.grid.chord[None, :]
    shape = moved_lift(wing, chord)
    return np.asarray(shape * (0.01 * moment(wing, wing.lift, np.ones_like(chord)) / moment(wing, shape, chord)))


def moved_lift(wing: Wing, place: FloatArray) -> FloatArray:
    """Return nodal forces (n_dofs,) [N] at load factor 1: lift times (place - its mean under the lift), total zero.

    `place` (n_nodes,) is any coordinate of the nodes.
    """
    vertical = wing.lift.reshape(-1, DOFS_PER_NODE)[:, 2]
    mean = float(vertical @ place / vertical.sum())
    moved = np.zeros((len(vertical), DOFS_PER_NODE))
    moved[:, 2] = vertical * (place - mean)
    return moved.ravel()


def moment(wing: Wing, force: FloatArray, place: FloatArray) -> float:
    """Return sum of vertical force times coordinate."""
    return float(force.reshape(-1, DOFS_PER_NODE)[:, 2] @ place)
