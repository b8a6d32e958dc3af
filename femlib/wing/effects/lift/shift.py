"""Lift moved along the span or the chord without changing its total."""

import numpy as np

from femlib.arrays import FloatArray
from femlib.mesh import DOFS_PER_NODE
from femlib.wing.model import Wing


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
