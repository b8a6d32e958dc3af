"""The way to the native core and back: a Problem as ranks and whole numbers, a table of nodes as a tree.

ranks     features as dense ranks, and the core's own problem
rows      a tree as a table of nodes and back
parts     parts of a tree that are asked for, as ranks
numbers   float64 in exact arithmetic
costs     weights, costs and penalty as whole numbers
grid      the same where they are not whole
coarse    a problem that may cut each feature in a few places only
"""

from octmip.trees.encoding.coarse import Coarse
from octmip.trees.encoding.costs import CAPACITY, IntegerCosts
from octmip.trees.encoding.grid import integer_costs
from octmip.trees.encoding.parts import rules_of, with_given_thresholds, with_old_sides
from octmip.trees.encoding.ranks import Ranks, native_arguments, native_problem, rank_features
from octmip.trees.encoding.rows import NodeRow, cut_as_split, rows_from_tree, split_as_cut, tree_from_rows

__all__ = [
    "CAPACITY",
    "Coarse",
    "IntegerCosts",
    "NodeRow",
    "Ranks",
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
