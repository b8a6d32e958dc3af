"""The last level: the best split into two leaves. What a leaf costs is known, so the master is the whole problem.

The price of a cut is exact there: `octmip.trees.mip.blocks.classcount` with one leaf on each side.
"""

import numpy as np

from octmip.trees.mip.benders.bounds import Bounds
from octmip.trees.mip.benders.master import Master
from octmip.trees.mip.benders.subproblem import Answer, Subproblem
from octmip.trees.mip.blocks import axis
from octmip.trees.nodes.tree import Leaf, Split


def best_stump(subproblem: Subproblem) -> Answer:
    """Return the best tree of one split, or of none; where the target is reached, one leaf and the target's proof."""
    problem, prices = subproblem.problem, subproblem.prices
    by_label = prices.of_labels(np.arange(problem.samples.n_samples))
    leaf = float(by_label.min())
    bounds, goal = Bounds.of_class_counts(problem, prices), min(leaf, subproblem.target)
    places = Master(bounds, leaf, goal).cheapest(bounds.price, goal, 1)
    if not places:
        return Answer(Leaf(int(by_label.argmin())), leaf, min(leaf, float(bounds.price.min(initial=np.inf))))
    cut = bounds.cut(places[0])
    left = bounds.is_left(cut)
    labels = [int(prices.of_labels(np.flatnonzero(side)).argmin()) for side in (left, ~left)]
    tree = Split(cut.feature, axis.threshold_at(cut.feature, cut.rank, bounds.ranks), *map(Leaf, labels))
    return Answer(tree, prices.of_tree(problem, tree), float(bounds.price[cut.place]))
