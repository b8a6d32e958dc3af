"""Sensors: which to install, for how many labels at once, in which order to read them, and what to do when one fails.

shared      trees for several labels under one budget of sensors, each sensor paid for once, with the proof
inspection  sensors read one after the other, paid when a path reaches them; the certificate
sequence    the best tree of an inspection, with its proof
"""

from octmip.sensing.inspection import Group, Inspection, InspectionCertificate, certify_inspection
from octmip.sensing.joint_certificate import JointCertificate, certify_joint
from octmip.sensing.joint_solution import HandSplit, JointSolution
from octmip.sensing.sequence import solve_inspection
from octmip.sensing.shared import shared_budget

__all__ = [
    "Group",
    "HandSplit",
    "Inspection",
    "InspectionCertificate",
    "JointCertificate",
    "JointSolution",
    "certify_inspection",
    "certify_joint",
    "shared_budget",
    "solve_inspection",
]
