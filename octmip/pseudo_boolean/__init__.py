"""Proofs of optimal axis-aligned trees of depth 1 and 2 that veripb checks, a program that shares nothing with octmip.

question   ranks and whole prices, or one sentence why there is no formula
formula    the pseudo-Boolean formula (OPB)
lines      lines of a cutting-planes proof
counts     what stumps cost on a part of the samples
column     cuts of a column: clauses moved to a grid of ranks
stump      lemmas: what every stump costs on a part of the samples
roots      which parts need lemmas
tree_proof all together
witness    a tree as an assignment
files      the two files
checker    veripb run on the formula made anew

The formula and each step of the proof: docs/theory/proofs/veripb.md.
"""

from octmip.pseudo_boolean.checker import VeripbReport, check_with_veripb
from octmip.pseudo_boolean.files import check_possible, formula_path, is_pseudo_boolean, write_proof

__all__ = [
    "VeripbReport",
    "check_possible",
    "check_with_veripb",
    "formula_path",
    "is_pseudo_boolean",
    "write_proof",
]
