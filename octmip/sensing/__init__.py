"""Sensors: which to install, for how many labels at once, and what to do if one fails.

placement   the sensors that the best tree reads and the value of each further one, with a bound; sensors chosen by
            rules and designs of experiment, to compare with
sensor_sets trees for several labels under one budget of sensors, each sensor paid for once, with proof and certificate
failed_gauge  the failed gauge found at a stated false-alarm rate, and its reading replaced by what the others say
"""

from octmip.sensing.designs import InformationDesign, by_chance, by_information, by_reading, by_tree
from octmip.sensing.failed_gauge import FaultDetector, Imputation, power
from octmip.sensing.joint_solution import JointSolution, certify_joint
from octmip.sensing.placement import (
    Placement,
    label_bound,
    place_sensors,
    placement_frontier,
    placement_on,
    problem_on,
)
from octmip.sensing.sensor_sets import shared_budget

__all__ = [
    "FaultDetector",
    "Imputation",
    "InformationDesign",
    "JointSolution",
    "Placement",
    "by_chance",
    "by_information",
    "by_reading",
    "by_tree",
    "certify_joint",
    "label_bound",
    "place_sensors",
    "placement_frontier",
    "placement_on",
    "power",
    "problem_on",
    "shared_budget",
]
