"""Root flexibility: the wing's mount turns under the root's bending moment instead of being rigid.

The wing is held at its root alone (statically determinate), so a turn of the mount moves it as a rigid body: inner
forces and strains stay, whatever the size. The signature is the gauges' answer to that rigid motion, zero but for
rounding. The effect is in the library so that a diagnosis says that strain cannot see it: a deflection or a frequency
can.
"""

from collections.abc import Mapping

import numpy as np

from femlib.arrays import FloatArray
from femlib.mesh import DOFS_PER_NODE
from femlib.wing.effects.card import WingEffect
from femlib.wing.effects.response import Response
from femlib.wing.model import MICRO, Wing

ROUNDING = 1e-6
"""Strain [microstrain] that a rigid motion may leave by rounding."""


def rolled(wing: Wing) -> FloatArray:
    """Return the displacements (n_dofs,) of the wing turned by one radian about the root's chord, tip up."""
    nodes = wing.structure.shells.mesh.nodes
    moved = np.zeros((len(nodes), DOFS_PER_NODE))
    moved[:, :3] = np.cross([1.0, 0.0, 0.0], nodes)
    moved[:, 3] = 1.0
    return moved.ravel()


def effect(response: Response) -> WingEffect:
    """Return the effect, seen by deflection alone."""
    wing = response.wing

    def strains(state: Mapping[str, float], load_factor: float, place: str, time: float) -> FloatArray:
        turned = rolled(wing)
        found = MICRO * (wing.strain_rows @ (1e-3 * load_factor * float(wing.lift @ turned) * turned))
        return np.where(np.abs(found) < ROUNDING, 0.0, found)

    return WingEffect(
        name="root_flexibility",
        parameter="turn of the mount per bending moment at the root",
        unit="rad/(kN m)",
        prior_sd=0.1,
        prior_source="a mount that raises the tip from 130 to 217 mm at load factor 3 has 0.17",
        separated_by="invisible in strain, as the wing is held at its root alone; deflection or frequency shows it",
        words="flexibility of the mount",
        action="add the flexibility of the mount to the twin",
        says=("the mount turns by {size}", "the mount turns by {size} the other way"),
        seen_by=("deflection", "frequency"),
        load_power=1,
        strains=strains,
        is_one_sided=True,
    )
