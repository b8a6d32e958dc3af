"""LeafShares: the leaf probabilities of a fitted classifier, counted when they are first asked for.

A fit needs none of them, and neither does `predict`. The object stands in the estimator from the fit on, because a
scikit-learn estimator must not change its attributes when it predicts.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import Literal

from octmip.trees.nodes.tree import Node
from octmip.trees.question.problem import Problem
from octmip.trees.tradeoff.leaf_shares import leaves_on_fresh_rows
from octmip.trees.uncertainty import LeafDistribution

Smoothing = float | Literal["out-of-fold"]


@dataclass(eq=False)
class LeafShares:
    """What the leaf probabilities are counted from; the fields are those of `leaves_on_fresh_rows`."""

    problem: Problem
    tree: Node
    smoothing: Smoothing
    seconds: float
    seed: int
    n_jobs: int

    @cached_property
    def distribution(self) -> LeafDistribution:
        """The classes in each leaf, smoothed or corrected."""
        if self.smoothing == "out-of-fold":
            effort = {"seed": self.seed, "n_jobs": self.n_jobs}
            return leaves_on_fresh_rows(self.problem, self.tree, seconds=self.seconds, **effort)
        return LeafDistribution.of(self.tree, self.problem, strength=self.smoothing)
