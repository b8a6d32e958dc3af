"""Lift distribution: the same total lift, carried further outboard than the ellipse.

Four shapes, all without change of the total: a shift linear, quadratic or cubic along the span, and the third harmonic
of the lifting line; others lie between. The size is the change of the bending moment at the root. Source: H.
Glauert, The Elements of Aerofoil and Airscrew Theory (1926), chapter 11 (the lift's Fourier series).
"""

from collections.abc import Mapping

import numpy as np

from femlib.arrays import FloatArray
from femlib.wing.effects.card import FixedForce, WingEffect
from femlib.wing.effects.lift_shift import moment, moved_lift
from femlib.wing.effects.response import Response


def effect(response: Response) -> WingEffect:
    """Return the effect."""
    wing = response.wing
    eta = wing.structure.shells.mesh.nodes[:, 1] / wing.span
    theta = np.arccos(np.clip(eta, 0.0, 1.0))
    shapes = {
        "linear": moved_lift(wing, eta),
        "quadratic": moved_lift(wing, eta**2),
        "toward the tip": moved_lift(wing, eta**3),
        "third harmonic": moved_lift(wing, np.sin(3.0 * theta) / np.maximum(np.sin(theta), 1e-6)),
    }
    root = moment(wing, wing.lift, eta)
    shapes = {name: shape * (0.01 * root / moment(wing, shape, eta)) for name, shape in shapes.items()}

    def force(state: Mapping[str, float], load_factor: float, place: str) -> FloatArray:
        return load_factor * shapes[place]

    return FixedForce(
        name="lift_distribution",
        parameter="change of the root bending moment at the same total lift",
        unit="%",
        prior_sd=4.0,
        prior_source="a vortex lattice carries 7 to 28 % more bending moment outboard than the ellipse",
        separated_by="it changes the strains outboard more than inboard, a scale changes all alike",
        load_power=1,
        response=response,
        force=force,
        places=tuple(shapes),
        n_between=2,
    )
