"""Lift distribution: the same total lift, carried further outboard than the ellipse.

Two shapes, both without change of the total: a shift linear along the span, and one that grows toward the tip
(cubic). The size is the change of the bending moment at the root.
"""

from collections.abc import Mapping

from femlib.arrays import FloatArray
from femlib.wing.effects.card import WingEffect
from femlib.wing.effects.lift_shift import moment, moved_lift
from femlib.wing.effects.response import Response


def effect(response: Response) -> WingEffect:
    """Return the effect."""
    wing = response.wing
    eta = wing.structure.shells.mesh.nodes[:, 1] / wing.span
    shapes = {"linear": moved_lift(wing, eta), "toward the tip": moved_lift(wing, eta**3)}
    root = moment(wing, wing.lift, eta)
    shapes = {name: shape * (0.01 * root / moment(wing, shape, eta)) for name, shape in shapes.items()}

    def force(state: Mapping[str, float], load_factor: float, place: str) -> FloatArray:
        return load_factor * shapes[place]

    return WingEffect(
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
    )
