"""Sets of near-optimal trees, and what they say of the sensors.

counting        all trees within some amount of the optimum, counted
near_set        the set: counts, intervals of cuts, best trees, uniform samples
roles           the optimum without each sensor, and of the trees that read it
whole_numbers   the problem in whole numbers, none of them rounded
"""

from octmip.trees.near_sets.counting import near_optimal
from octmip.trees.near_sets.near_set import NearOptimalSet, NearTree, RootInterval
from octmip.trees.near_sets.roles import Role, SensorRole, SensorRoles, sensor_roles
from octmip.trees.near_sets.without import Without

__all__ = [
    "NearOptimalSet",
    "NearTree",
    "Role",
    "RootInterval",
    "SensorRole",
    "SensorRoles",
    "Without",
    "near_optimal",
    "sensor_roles",
]
