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

from octmip.sensing.failure.detection import FaultDetector, power
from octmip.sensing.failure.imputation import Filling
from octmip.sensing.failure.robust import solve_expected, solve_worst
from octmip.sensing.failure.scenarios import (
    DEAD,
    FailureCertificate,
    FailureProblem,
    Fault,
    Scenario,
    certify_failures,
    failures,
)
from octmip.sensing.failure.surrogates import GuardedSplit, GuardedTree, Surrogate, with_surrogates
from octmip.sensing.placement.designs import InformationDesign, by_chance, by_information, by_reading, by_tree
from octmip.sensing.placement.placement import (
    Placement,
    label_bound,
    place_sensors,
    placement_frontier,
    placement_on,
    problem_on,
    sample_bound,
)
from octmip.sensing.sequential.problem import Group, Inspection, InspectionCertificate, certify_inspection
from octmip.sensing.sequential.solve import solve_inspection
from octmip.sensing.shared.budget import shared_budget
from octmip.sensing.shared.certificate import JointCertificate, certify_joint
from octmip.sensing.shared.solution import HandSplit, JointSolution

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
