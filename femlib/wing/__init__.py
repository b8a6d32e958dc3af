"""The UAV wing: planform, structure, damage regions, loads, gauges, and the model made of them."""

from femlib.wing.aerodynamics import AeroLoad, FlightPoint, vortex_lattice
from femlib.wing.bent import BentWing, bend
from femlib.wing.inertia import inertial_load
from femlib.wing.model import Wing, uav_wing
from femlib.wing.reduced import ReducedWing, reduce_wing
from femlib.wing.twin import WingTwin, uav_twin

__all__ = [
    "AeroLoad",
    "BentWing",
    "FlightPoint",
    "ReducedWing",
    "Wing",
    "WingTwin",
    "bend",
    "inertial_load",
    "reduce_wing",
    "uav_twin",
    "uav_wing",
    "vortex_lattice",
]
