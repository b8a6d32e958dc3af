"""Sensors: which to install, for how many labels at once, and what a failed one would have read.

placement   the sensors that the best tree reads and the value of each further one, with a bound
sensor_sets trees for several labels under one budget of sensors, each sensor paid for once: joint_solution and its
            certificate
designs     sensors chosen by rules, to compare with
imputation  the reading of a failed gauge, from what the others say
monitor_design, enrichment
            trees of a monitor from its twin, and new ones once readings leave its library
"""

from octmip.sensing.designs import by_chance, by_reading, by_tree
from octmip.sensing.imputation import Imputation
from octmip.sensing.joint_solution import JointSolution, certify_joint
from octmip.sensing.placement import (
    Placement,
    label_bound,
    place_sensors,
    placement_frontier,
    placement_on,
)
from octmip.sensing.sensor_sets import shared_budget

__all__ = [
    "Imputation",
    "JointSolution",
    "Placement",
    "by_chance",
    "by_reading",
    "by_tree",
    "certify_joint",
    "label_bound",
    "place_sensors",
    "placement_frontier",
    "placement_on",
    "shared_budget",
]
