"""Subproblems and answers: the best tree for some samples, and the price below which there is none."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from octmip.trees.mip.prices import Prices
from octmip.trees.nodes.tree import Node
from octmip.trees.question.problem import Problem


@dataclass(frozen=True, slots=True, eq=False)
class Subproblem:
    """The samples of a node and the trees for them.

    Attributes
    ----------
    problem
        the node's samples, and the depth, leaf size and budget below it.
    prices
        of these samples.
    rows
        (n_samples,) of these samples in the whole problem.
    target
        a bound of this price is as good as a proof: no better tree is of use above.
    """

    problem: Problem
    prices: Prices
    rows: NDArray[np.int64]
    target: float = math.inf


@dataclass(frozen=True, slots=True, eq=False)
class Answer:
    """The best tree found for a subproblem, and the price below which there is none."""

    tree: Node
    price: float
    bound: float

    @property
    def is_proven(self) -> bool:
        """Whether the tree is the best."""
        return self.bound >= self.price
