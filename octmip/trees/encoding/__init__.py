"""The way to the native core and back: a Problem as ranks and whole numbers, a table of nodes as a tree.

ranks          features as dense ranks, the core's own problem, a tree as a table of nodes and back
costs          weights, costs and penalty as whole numbers
parts          parts of a tree that are asked for, as ranks
sample_costs   costs of single samples as weighted rows
repeated_rows  a least weight of leaves as a number of rows
coarse         a problem that may cut each feature in a few places only
"""

from octmip.trees.encoding.coarse import Coarse
from octmip.trees.encoding.costs import CAPACITY, IntegerCosts, integer_costs
from octmip.trees.encoding.parts import rules_of, with_given_thresholds, with_old_sides
from octmip.trees.encoding.ranks import (
    NodeRow,
    Ranks,
    centred_tree,
    cut_as_split,
    native_arguments,
    native_problem,
    rank_features,
    rows_from_tree,
    split_as_cut,
    tree_from_rows,
)

__all__ = [
    "CAPACITY",
    "Coarse",
    "IntegerCosts",
    "NodeRow",
    "Ranks",
    "centred_tree",
    "cut_as_split",
    "integer_costs",
    "native_arguments",
    "native_problem",
    "rank_features",
    "rows_from_tree",
    "rules_of",
    "split_as_cut",
    "tree_from_rows",
    "with_given_thresholds",
    "with_old_sides",
]
