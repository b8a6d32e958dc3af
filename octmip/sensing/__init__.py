"""Sensors: which to install, for how many labels at once, in which order to read them, and what to do when one fails.

placement   the sensors that the best tree reads; what each further one is worth, with its bound
designs     sensors chosen by rules and designs of experiment, to compare with
shared      trees for several labels under one budget of sensors, each sensor paid for once, with the proof
inspection  sensors read one after the other, paid when a path reaches them; the certificate
sequence    the best tree of an inspection, with its proof
scenarios   what may fail, how likely, and what a tree costs then; the certificate
robust      trees of least expected or least worst cost over the scenarios
surrogates  what a tree asks instead of a missing reading
filling     a missing reading from the others
detection   which gauge has failed, at a stated false-alarm rate
"""

from octmip.sensing.designs import InformationDesign, by_chance, by_information, by_reading, by_tree
from octmip.sensing.detection import FaultDetector, power
from octmip.sensing.filling import Filling
from octmip.sensing.inspection import Group, Inspection, InspectionCertificate, certify_inspection
from octmip.sensing.joint_certificate import JointCertificate, certify_joint
from octmip.sensing.joint_solution import HandSplit, JointSolution
from octmip.sensing.placement import (
    Placement,
    label_bound,
    place_sensors,
    placement_frontier,
    placement_on,
    problem_on,
    sample_bound,
)
from octmip.sensing.robust import solve_expected, solve_worst
from octmip.sensing.scenarios import (
    DEAD,
    FailureCertificate,
    FailureProblem,
    Fault,
    Scenario,
    certify_failures,
    failures,
)
from octmip.sensing.sequence import solve_inspection
from octmip.sensing.shared import shared_budget
from octmip.sensing.surrogates import GuardedSplit, GuardedTree, Surrogate, with_surrogates

__all__ = [
    "DEAD",
    "FailureCertificate",
    "FailureProblem",
    "Fault",
    "FaultDetector",
    "Filling",
    "Group",
    "GuardedSplit",
    "GuardedTree",
    "HandSplit",
    "InformationDesign",
    "Inspection",
    "InspectionCertificate",
    "JointCertificate",
    "JointSolution",
    "Placement",
    "Scenario",
    "Surrogate",
    "by_chance",
    "by_information",
    "by_reading",
    "by_tree",
    "certify_failures",
    "certify_inspection",
    "certify_joint",
    "failures",
    "label_bound",
    "place_sensors",
    "placement_frontier",
    "placement_on",
    "power",
    "problem_on",
    "sample_bound",
    "shared_budget",
    "solve_expected",
    "solve_inspection",
    "solve_worst",
    "with_surrogates",
]
