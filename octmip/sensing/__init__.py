"""Sensors: which to install, for how many labels at once, in which order to read them, and what to do if one fails.

placement   the sensors that the best tree reads and the value of each further one, with a bound; sensors chosen by
            rules and designs of experiment, to compare with
shared      trees for several labels under one budget of sensors, each sensor paid for once, with proof and certificate
sequential  sensors read one after the other, paid for when a path reaches them: the best tree, proof and certificate
failure     scenarios of failed sensors and their certificate; trees of least expected or least worst cost over them;
            surrogate splits and imputation for a missing reading; detection of the failed gauge at a stated
            false-alarm rate
"""

from octmip.sensing.failure.detection import FaultDetector, power
from octmip.sensing.failure.imputation import Imputation
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
from octmip.sensing.sequential.problem import Group, SequentialCertificate, SequentialProblem, certify_sequential
from octmip.sensing.sequential.solve import solve_sequential
from octmip.sensing.shared.budget import shared_budget
from octmip.sensing.shared.certificate import JointCertificate, certify_joint
from octmip.sensing.shared.solution import BaselineSplit, JointSolution

__all__ = [
    "DEAD",
    "BaselineSplit",
    "FailureCertificate",
    "FailureProblem",
    "Fault",
    "FaultDetector",
    "Group",
    "GuardedSplit",
    "GuardedTree",
    "Imputation",
    "InformationDesign",
    "JointCertificate",
    "JointSolution",
    "Placement",
    "Scenario",
    "SequentialCertificate",
    "SequentialProblem",
    "Surrogate",
    "by_chance",
    "by_information",
    "by_reading",
    "by_tree",
    "certify_failures",
    "certify_joint",
    "certify_sequential",
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
    "solve_sequential",
    "solve_worst",
    "with_surrogates",
]
