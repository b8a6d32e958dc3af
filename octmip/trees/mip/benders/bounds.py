"""Bounds of what the trees below each side of every cut cost at least: the Benders cuts of a node.

A subproblem gives the least price v(S) of a tree for some samples S. For any other samples S'

    v(S') >= v(S) - sum over i in S but not in S' of worst_i,      worst_i = the price of i's most expensive label,

because a tree for S' also answers S, and pays at most worst_i more for each sample that it was not made for. With
S' = what a cut sends left, or right, one subproblem bounds both sides of every cut of every feature:

    theta_left  >= sum_c max(0, v - W(S without L_c)) x_c,      theta_right >= sum_c max(0, v - W(S without R_c)) x_c

where x_c = 1 for the cut that the node makes. As exactly one x_c is 1, the largest coefficient of all these rows is a
valid one, so a side keeps one row, whose coefficients rise.

Leaf sizes. A tree for S' may have leaves that hold too few samples of S, unless S' lies within S. So the value of a
problem with a leaf size above 1 is used where S' lies within S; elsewhere that of the problem without it.

Sensor budget. A tree below a cut may read the cut's own sensor for nothing, so a value holds for cuts of that sensor.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from octmip.trees.encoding import Ranks, rank_features
from octmip.trees.mip.benders.cuts import Cut, Cuts
from octmip.trees.mip.blocks import axis
from octmip.trees.mip.blocks.classcount import ClassCount
from octmip.trees.mip.prices import Prices
from octmip.trees.question.problem import Problem

NEVER = np.inf  # the bound of a cut that no tree of the problem makes


@dataclass(slots=True, eq=False)
class Bounds:
    """The cuts of a node and what the trees below each of their sides cost at least.

    Attributes
    ----------
    problem, prices, ranks
        of the node's samples.
    cuts
        of the node, in the order of the following.
    left, right
        (n_cuts,) least price of a tree for the samples on that side.
    both
        (n_cuts,) least price of the two together where it is known to be more than the sum.
    """

    problem: Problem
    prices: Prices
    ranks: Ranks
    cuts: Cuts
    left: NDArray[np.float64]
    right: NDArray[np.float64]
    both: NDArray[np.float64]

    @classmethod
    def of_class_counts(cls, problem: Problem, prices: Prices) -> "Bounds":
        """Return the bounds that follow from class counts alone."""
        ranks = rank_features(problem)
        usable = np.array(axis.usable_features(problem, ranks), dtype=np.int64)
        counts, n_leaves = ClassCount(problem, ranks, prices), 2 ** (problem.shape.depth - 1)
        worst = prices.costs.max(axis=1)
        cuts = Cuts.of(ranks, usable)
        on_left = cuts.left_of(prices.weights, prices.profile, prices.n_profiles)
        on_right = counts.total() - on_left
        left, right = (side @ worst - counts.earned(side, n_leaves) for side in (on_left, on_right))
        out = cls(problem, prices, ranks, cuts, left, right, np.zeros(len(left)))
        out._leave_out_small_sides()
        return out

    def _leave_out_small_sides(self) -> None:
        if self.problem.shape.leaf_size > 1:
            n_left = self._by_cut(np.ones(self.problem.samples.n_samples))
            smaller = np.minimum(n_left, self.problem.samples.n_samples - n_left)
            self.both[smaller < self.problem.shape.leaf_size] = NEVER

    @property
    def price(self) -> NDArray[np.float64]:
        """(n_cuts,) least price of a tree that makes each cut."""
        return np.asarray(np.maximum(self.left + self.right, self.both) + self.prices.penalty)

    def depth_in_run(self, is_open: NDArray[np.bool_]) -> NDArray[np.int64]:
        """Return how far each cut lies inside its run of open cuts of one feature, 0 where it is not open, (n_cuts,).

        The answer of a cut bounds its neighbours, on either side. So of cuts that are alike the innermost teaches most.
        """
        feature = self.cuts.feature
        place = np.arange(1, len(feature) + 1)
        begins = np.diff(feature, prepend=-1) != 0
        ends = np.diff(feature, append=-1) != 0
        before = np.maximum.accumulate(np.where(is_open, np.where(begins, place - 1, 0), place))
        after = np.minimum.accumulate(np.where(is_open, np.where(ends, place + 1, len(place) + 1), place)[::-1])[::-1]
        return np.asarray(np.minimum(place - before, after - place))

    def cut(self, place: int) -> Cut:
        """Return a cut by its place."""
        return Cut(place, int(self.cuts.feature[place]), int(self.cuts.rank[place]))

    def is_left(self, cut: Cut) -> NDArray[np.bool_]:
        """Return which samples a cut sends left, (n_samples,)."""
        return np.asarray(self.ranks.column(cut.feature) <= cut.rank)

    def learn(
        self, samples: NDArray[np.bool_], price: float, *, within: bool = False, sensor: int | None = None
    ) -> None:
        """Raise the bounds by what a tree for some samples costs at least.

        Parameters
        ----------
        samples
            (n_samples,) the samples of the subproblem.
        price
            its least price.
        within
            whether that holds only for samples within `samples`.
        sensor
            the sensor of the cuts that it holds for; None: of all.
        """
        worst = self.prices.weights * self.prices.costs[self.prices.profile].max(axis=1)
        inside = self._by_cut(np.where(samples, worst, 0.0))
        left, right = price - (worst[samples].sum() - inside), price - inside
        if within:
            outside = self._by_cut((~samples).astype(np.float64))
            left[outside > 0] = 0
            right[outside < (~samples).sum()] = 0
        if sensor is not None:
            is_other = self.problem.shape.sensor_index[self.cuts.feature] != sensor
            left[is_other] = right[is_other] = 0
        np.maximum(self.left, left, out=self.left)
        np.maximum(self.right, right, out=self.right)

    def _by_cut(self, amount: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the sum of an amount per sample over the samples left of each cut, (n_cuts,)."""
        return self.cuts.left_of(amount)[:, 0]
