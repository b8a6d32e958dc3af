"""The UAV wing: planform, structure, damage regions, loads, gauges, and the model made of them."""

from femlib.wing.bent import BentWing, bend
from femlib.wing.inertia import inertial_load
from femlib.wing.model import Wing, tapered_wing, uav_wing
from femlib.wing.modes import buckle, mass_matrix, vibrate
from femlib.wing.reduced import ReducedWing, reduce_wing
from femlib.wing.twin import WingTwin, full_twin, reduced_twin, saved_twin, uav_twin

__all__ = [
    "BentWing",
    "ReducedWing",
    "Wing",
    "WingTwin",
    "bend",
    "buckle",
    "full_twin",
    "inertial_load",
    "mass_matrix",
    "reduce_wing",
    "reduced_twin",
    "saved_twin",
    "tapered_wing",
    "uav_twin",
    "uav_wing",
    "vibrate",
]
