"""Trees that survive reading errors: least worst case while gauges are off within bands.

bands        how far each gauge may be off, and the readings that follow
constant     the worst constant error of a tree
recount      the worst case of a tree, recounted, and the certificate of a solution
least_worst  the tree of least worst case, with its proof to depth 2
"""

from octmip.trees.worst_case.bands import Bands
from octmip.trees.worst_case.constant import ConstantBias
from octmip.trees.worst_case.least_worst import WorstCaseSolution, solve
from octmip.trees.worst_case.recount import WorstCase, certify_worst_case, worst_case

__all__ = ["Bands", "ConstantBias", "WorstCase", "WorstCaseSolution", "certify_worst_case", "solve", "worst_case"]
