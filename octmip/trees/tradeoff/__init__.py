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

from octmip.trees.tradeoff.choice import Choice, choose_tree
from octmip.trees.tradeoff.frontier import Point, trace_frontier
from octmip.trees.tradeoff.held_out import Comparison, Samples, Score, score
from octmip.trees.tradeoff.path import PathTree, PenaltyPath, trace_path
from octmip.trees.tradeoff.risk import RiskPoint, trace_risk_frontier
from octmip.trees.tradeoff.steps import Step

__all__ = [
    "Choice",
    "Comparison",
    "PathTree",
    "PenaltyPath",
    "Point",
    "RiskPoint",
    "Samples",
    "Score",
    "Step",
    "choose_tree",
    "score",
    "trace_frontier",
    "trace_path",
    "trace_risk_frontier",
]
