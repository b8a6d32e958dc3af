"""Tradeoffs: error against depth, sensors and simplicity, and the depth and leaf penalty that hold on unseen samples.

frontier   the least cost against depth, sensor budget or leaf penalty, each point with its bound
path       for every leaf penalty the best tree: all the trees that are best for some penalty
risk       missed critical states against false alarms, over the cost of a failure
baselines  linear models, pruned CART, forest and boosting on the same samples
held_out   rows kept from training, and what a tree and CART lose there
leaf_shares  leaf probabilities, corrected by rows held out of refits
family     the kinds of trees that are chosen among, each with its path
validation what trees cost on rows held out, and the chosen one on new rows
repeats    samples as rows that folds can part, so that weight 2 is as two rows
steps      the intervals of the penalty on which the cost on rows held out does not change
choice     kind, depth and leaf penalty by cross-validation over those paths
default    the answer to whoever names no depth
"""

from octmip.trees.tradeoff.baselines import baselines_of
from octmip.trees.tradeoff.choice import RULES, Choice, Rule, choose_default, choose_tree
from octmip.trees.tradeoff.default import DefaultAnswer, solve_default
from octmip.trees.tradeoff.family import Family, default_families
from octmip.trees.tradeoff.frontier import OVERS, Over, Point, default_values, trace_frontier
from octmip.trees.tradeoff.held_out import (
    Comparison,
    Samples,
    Score,
    beside_cart,
    held_out_rows,
    score,
    score_of,
    strata_of,
)
from octmip.trees.tradeoff.leaf_shares import leaves_on_fresh_rows
from octmip.trees.tradeoff.path import PathTree, PenaltyPath, trace_path
from octmip.trees.tradeoff.risk import RiskPoint, trace_risk_frontier
from octmip.trees.tradeoff.steps import Step
from octmip.trees.tradeoff.validation import Expectation, Expected

__all__ = [
    "OVERS",
    "RULES",
    "Choice",
    "Comparison",
    "DefaultAnswer",
    "Expectation",
    "Expected",
    "Family",
    "Over",
    "PathTree",
    "PenaltyPath",
    "Point",
    "RiskPoint",
    "Rule",
    "Samples",
    "Score",
    "Step",
    "baselines_of",
    "beside_cart",
    "choose_default",
    "choose_tree",
    "default_families",
    "default_values",
    "held_out_rows",
    "leaves_on_fresh_rows",
    "score",
    "score_of",
    "solve_default",
    "strata_of",
    "trace_frontier",
    "trace_path",
    "trace_risk_frontier",
]
