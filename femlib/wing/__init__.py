"""The UAV wing: planform, structure, damage regions, loads, gauges, and the model made of them."""

from femlib.wing.bent import BentWing, bend
from femlib.wing.model import Wing, uav_wing
from femlib.wing.twin import WingTwin, uav_twin

__all__ = ["BentWing", "Wing", "WingTwin", "bend", "uav_twin", "uav_wing"]
