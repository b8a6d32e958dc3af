"""Class counts: the most that q leaves can earn on samples of which only the class weights are known.

Let Cmax_i be the largest cost of class i and gain[i, k] = Cmax_i - C[i, k] what predicting k earns over it. The q
leaves below one side of a split name at most q labels Q, so with class weights W on that side they earn at most

    G_q(W) = max over |Q| = q of  sum_i W_i max_{k in Q} gain[i, k]          (0/1 costs: the q largest of W)

whatever splits lie between. A split with class weights W_left, W_right costs at least
W_all @ Cmax - G_q(W_left) - G_q(W_right) (and its penalty). At depth 1 (q = 1) that is the exact cost of the stump.
"""

import math
from dataclasses import dataclass
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from octmip.trees.encoding import Ranks
from octmip.trees.mip.prices import Prices
from octmip.trees.question.problem import Problem

MOST_LABEL_SETS = 500  # beyond it every class is taken to be earned: still a bound, a weaker one


@dataclass(frozen=True, slots=True, eq=False)
class ClassCount:
    """Class weights on the left of every cut of every feature, and the most that leaves can earn on them."""

    problem: Problem
    ranks: Ranks
    prices: Prices

    @property
    def worst(self) -> float:
        """Cost when every sample has its most expensive label."""
        return self.prices.worst

    @property
    def gain(self) -> NDArray[np.float64]:
        """(n_profiles, n_classes) what predicting k for a unit of a profile earns over its most expensive label."""
        costs = self.prices.costs
        return np.asarray(costs.max(axis=1, keepdims=True) - costs)

    def total(self) -> NDArray[np.float64]:
        """Return the class weights of all samples, shape (n_profiles,)."""
        counted = np.bincount(self.prices.profile, self.prices.weights, self.prices.n_profiles)
        return counted.astype(np.float64)

    def left_of_cuts(self, j: int) -> NDArray[np.float64]:
        """Return the class weights left of each cut of feature j, shape (n_cuts, n_profiles)."""
        shape = (self.ranks.n_values[j], self.prices.n_profiles)
        flat = self.ranks.column(j).astype(np.int64) * shape[1] + self.prices.profile
        weights = np.bincount(flat, self.prices.weights, shape[0] * shape[1]).reshape(shape)
        return np.asarray(weights.cumsum(axis=0)[:-1])

    def earned(self, weights: NDArray[np.float64], n_leaves: int) -> NDArray[np.float64]:
        """Return G_q for each row of `weights` (n, n_profiles) with q = `n_leaves`, shape (n,)."""
        n_classes = self.problem.samples.n_classes
        if n_leaves >= n_classes or math.comb(n_classes, n_leaves) > MOST_LABEL_SETS:
            return np.asarray(weights @ self.gain.max(axis=1))
        gain = self.gain
        sets = [gain[:, list(labels)].max(axis=1) for labels in combinations(range(n_classes), n_leaves)]
        return np.asarray((weights @ np.array(sets).T).max(axis=1))

    def earned_by_side(self, j: int, n_leaves: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return the most that `n_leaves` leaves earn left and right of each cut of feature j, shapes (n_cuts,)."""
        left = self.left_of_cuts(j)
        return self.earned(left, n_leaves), self.earned(self.total() - left, n_leaves)

    def bound_by_cut(self, j: int) -> NDArray[np.float64]:
        """Return the class-count bound of every tree whose root makes each cut of feature j, shape (n_cuts,)."""
        left, right = self.earned_by_side(j, 2 ** (self.problem.shape.depth - 1))
        return self.worst - left - right + self.prices.penalty
