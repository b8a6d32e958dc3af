"""Trees that survive drift: least worst case while gauges are off within bands.

bands        how far each gauge may be off, and the readings that follow
constant     the worst constant error of a tree
recount      the worst case of a tree, recounted, and the certificate of a solution
least_worst  the tree of least worst case, with its proof to depth 2
"""

from octmip.trees.drift.bands import Bands
from octmip.trees.drift.constant import ConstantBias
from octmip.trees.drift.least_worst import DriftSolution, solve
from octmip.trees.drift.recount import WorstCase, certify_drift, worst_case

__all__ = ["Bands", "ConstantBias", "DriftSolution", "WorstCase", "certify_drift", "solve", "worst_case"]
