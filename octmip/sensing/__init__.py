"""Sensors: which to install, in which order to read them, and what to do when one fails.

inspection  sensors read one after the other, paid when a path reaches them; the certificate
sequence    the best tree of an inspection, with its proof
"""

from octmip.sensing.inspection import Group, Inspection, InspectionCertificate, certify_inspection
from octmip.sensing.sequence import solve_inspection

__all__ = [
    "Group",
    "Inspection",
    "InspectionCertificate",
    "certify_inspection",
    "solve_inspection",
]
