"""CART, the greedy tree of Breiman, Friedman, Olshen & Stone (1984), by scikit-learn, as a Solution.

It is the yardstick of every heuristic and a first incumbent of every proof. What it minimises at a node is the Gini
impurity of its two sides, weighted, of numbers the squared or absolute error; the objective of the Problem enters
afterwards, when leaves take the label of least cost and splits that do not pay their penalty are cut away from the
bottom up.

scikit-learn compares in float32. It is therefore trained on dense ranks, which float32 holds exactly up to 2^24
distinct values; thresholds come back as midpoints of the float64 values on both sides of the cut, as it would set them
itself. A separable column 900 + 1e-6 i is separated.

Missing readings stay missing: scikit-learn sends them to the side of its choice at each split.
"""

import math
import time
import warnings
from dataclasses import dataclass, replace
from importlib import metadata
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from octmip.trees.answer.solution import Limits, ProgressCallback, Solution, Stop
from octmip.trees.encoding import Ranks, rank_features
from octmip.trees.methods.options import NO_OPTIONS, Options
from octmip.trees.nodes.digits import midpoint
from octmip.trees.nodes.tree import SIDES, Leaf, Node, Split, complexity
from octmip.trees.question.problem import Problem

if TYPE_CHECKING:
    import sklearn

MEASURED_WORK = 1e7
"""Samples times columns, classes and levels from which on the time of a level is measured: some tenths of a second."""


def greedy_tree(
    problem: Problem,
    *,
    limits: Limits = Limits(),  # noqa: B008 (frozen)
    incumbent: Node | None = None,
    seed: int = 0,
    n_jobs: int = 1,
    progress: ProgressCallback | None = None,
    options: Options = NO_OPTIONS,
) -> Solution:
    """Return scikit-learn's CART for a problem, without a bound.

    Weights, leaf_size, leaf_weight, depth and the features of allowed_splits are honoured while the tree grows. Under a
    sensor budget the tree grows on a set of sensors that is itself chosen greedily: always the affordable sensor whose
    addition costs least. A hyperplane problem gets its axis-aligned tree. Of the limits `seconds` is looked at
    between the sensors of that choice, and gives a large table fewer levels; `nodes` are the most splits: where there
    are more samples, the tree grows best first, up to them. `incumbent`, `n_jobs`, `progress` and `options` are there
    because every solver has them.

    Raises
    ------
    ProblemError
        from the limits only; every Problem has a greedy tree, in the worst case a single leaf.
    """
    shape = problem.shape
    start = time.perf_counter()
    builder = _GreedyBuilder(problem, rank_features(problem), seed, limits.nodes, shape.depth)
    builder, tree = _grown_in_time(builder, start + limits.seconds)
    stop = Stop.FINISHED if builder.levels == shape.depth else Stop.TIME
    if shape.sensor_cost_of(tree) > shape.sensor_limit:
        tree, stop = _within_budget(builder, start + limits.seconds)
    return greedy_solution(problem, problem.with_sides(tree), seed, stop, time.perf_counter() - start)


def greedy_solution(
    problem: Problem, tree: Node, seed: int, stop: Stop = Stop.FINISHED, seconds: float = 0.0
) -> Solution:
    """Return CART's tree, or a pruning of it, as a Solution without a bound."""
    return Solution(
        tree=tree,
        objective=problem.objective(tree),
        bound=-math.inf,
        stop=stop,
        seconds=seconds,
        n_nodes=0,
        solver="cart",
        version=f"scikit-learn {metadata.version('scikit-learn')}",
        seed=seed,
    )


@dataclass(frozen=True, slots=True, eq=False)
class _GreedyBuilder:
    """Grows one CART on any subset of the features of a problem."""

    problem: Problem
    ranks: Ranks
    seed: int
    most_splits: float
    levels: int

    def usable_features(self) -> NDArray[np.int64]:
        """Return the features that may be split on at all: allowed, and not constant."""
        usable = [
            j
            for j in range(self.problem.samples.n_features)
            if self.problem.shape.is_allowed((j,)) and self.ranks.n_values[self.column(j)] > 1
        ]
        return np.array(usable, dtype=np.int64)

    def column(self, feature: int) -> int:
        """Return the column of ranks that reads a feature, missing readings ranked above all others."""
        return self.ranks.columns_of(feature)[-1]

    def lacks(self, feature: int, rows: NDArray[np.int64]) -> NDArray[np.bool_]:
        """Return which of the rows lack the reading of a feature."""
        return np.asarray(np.isnan(self.problem.samples.features[rows, feature]))

    def build(self, features: NDArray[np.int64]) -> Node:
        """Return CART on these features, its leaves and splits judged by the objective of the problem."""
        from sklearn.tree import DecisionTreeClassifier, DecisionTreeRegressor  # only here: it takes a CPU second

        problem = self.problem
        least = problem.shape.least_leaf_weight / (problem.samples.weights.sum() or 1.0)
        if len(features) == 0 or least > 0.5:  # two leaves of so much weight there are not
            return problem.best_leaf()
        limits: dict[str, float] = {"max_depth": self.levels, "min_samples_leaf": problem.shape.leaf_size}
        limits |= {"random_state": self.seed, "min_weight_fraction_leaf": least}
        targets = problem.samples.codes
        if problem.loss.predicts == "class":
            grower = DecisionTreeClassifier(**limits)
        else:
            criterion = "squared_error" if problem.number_loss.slopes is None else "absolute_error"
            grower = DecisionTreeRegressor(criterion=criterion, **limits)
            targets, *_ = unit_sized(targets)
        if self.most_splits < problem.samples.n_samples - 1:  # best first
            grower.set_params(max_leaf_nodes=max(2, int(self.most_splits) + 1))
        columns = np.empty((problem.samples.n_samples, len(features)), dtype=np.float32)
        for k, feature in enumerate(features.tolist()):
            columns[:, k] = self.ranks.column(self.column(feature))
            if problem.samples.takes_missing:
                columns[np.isnan(problem.samples.features[:, feature]), k] = np.nan
        with warnings.catch_warnings():  # scikit-learn doubts that so many classes are classes
            warnings.filterwarnings("ignore", message="The number of unique classes", category=UserWarning)
            grower.fit(columns, targets, sample_weight=problem.samples.weights)
        return self._pruned(grower.tree_, 0, features, np.arange(problem.samples.n_samples))[0]

    def _pruned(
        self, grown: "sklearn.tree._tree.Tree", node: int, features: NDArray[np.int64], rows: NDArray[np.int64]
    ) -> tuple[Node, float]:
        """Return the subtree of scikit-learn's `node` over `rows` and its cost, as a leaf where that costs no more."""
        leaf, leaf_cost = self.problem.leaf_and_cost(rows)
        if grown.children_left[node] < 0:
            return leaf, leaf_cost
        feature = int(features[grown.feature[node]])
        split, left = self._split(grown, node, feature, rows)
        if split is None:
            return leaf, leaf_cost
        left_tree, left_cost = self._pruned(grown, grown.children_left[node], features, rows[left])
        right_tree, right_cost = self._pruned(grown, grown.children_right[node], features, rows[~left])
        cost = left_cost + right_cost + self.problem.shape.leaf_penalty
        if cost >= leaf_cost:
            return leaf, leaf_cost
        return replace(split, left=left_tree, right=right_tree), cost

    def _split(
        self, grown: "sklearn.tree._tree.Tree", node: int, feature: int, rows: NDArray[np.int64]
    ) -> tuple[Split | None, NDArray[np.bool_]]:
        """Return scikit-learn's split of some rows with leaves below, and which go left; None where a side is small."""
        ranks, values = self.ranks.column(self.column(feature))[rows], self.ranks.values[self.column(feature)]
        is_missing, missing = self.lacks(feature, rows), None
        left = ranks <= grown.threshold[node]
        if is_missing.any():
            missing = SIDES[0] if grown.missing_go_to_left[node] else SIDES[1]
            left[is_missing] = missing == "left"
        if min(int(left.sum()), int((~left).sum())) < self.problem.shape.leaf_size:
            return None, left
        weights = self.problem.samples.weights[rows]
        if min(weights[left].sum(), weights[~left].sum()) < self.problem.shape.least_leaf_weight:
            return None, left
        below, above = ranks[left & ~is_missing], ranks[~left & ~is_missing]
        if not len(below) or not len(above):
            return Split(feature, None, Leaf(0), Leaf(0), missing=missing), left
        threshold = midpoint(float(values[below.max()]), float(values[above.min()]))
        return Split(feature, threshold, Leaf(0), Leaf(0), missing=missing), left


def unit_sized(targets: NDArray[np.float64]) -> tuple[NDArray[np.float64], float, int]:
    """Return targets as (target - centre) / 2^exponent, below 1 in size and whole numbers exact; centre; exponent.

    CART's tree does not depend on offset and unit of its targets, scikit-learn's does: it takes the square of the mean
    from the mean of squares, where an offset leaves no digit, and a node of an impurity below some 1e-16 for a leaf.
    """
    centre = float(np.partition(targets, len(targets) // 2)[len(targets) // 2])
    halves = targets / 2 - centre / 2  # a difference of two may be more than the largest number
    exponent = int(np.frexp(np.abs(halves).max())[1])
    return np.ldexp(halves, -exponent), centre, exponent + 1


def _grown_in_time(builder: _GreedyBuilder, deadline: float) -> tuple[_GreedyBuilder, Node]:
    """Return the tree that can be grown by a deadline and its builder: of all levels, or as the first one lets expect.

    scikit-learn looks at no clock, and at each level goes through all samples, columns and classes.
    """
    problem, start = builder.problem, time.perf_counter()
    work = problem.samples.features.size * max(1, problem.samples.n_classes) * problem.shape.depth
    usable = builder.usable_features()
    if math.isinf(deadline) or work < MEASURED_WORK or problem.shape.depth == 1:
        return builder, builder.build(usable)
    shallow = replace(builder, levels=1)
    tree, now = shallow.build(usable), time.perf_counter()
    levels = min(problem.shape.depth, int((deadline - now) / max(now - start, 1e-9)))
    if levels <= 1:
        return shallow, tree
    deeper = replace(builder, levels=levels)
    return deeper, deeper.build(usable)


def _within_budget(builder: _GreedyBuilder, deadline: float) -> tuple[Node, Stop]:
    """Return the best of the trees grown while sensors are added one by one, and why that ended."""
    problem = builder.problem
    usable = builder.usable_features()
    sensor_of_usable = problem.shape.sensor_index[usable]
    chosen = set(np.flatnonzero(problem.shape.sensor_costs == 0).tolist())
    best = builder.build(usable[np.isin(sensor_of_usable, list(chosen))])
    best_rank = _rank(problem, best)
    while affordable := _affordable(problem, chosen, set(sensor_of_usable.tolist())):
        trials = []
        for sensor in affordable:
            if time.perf_counter() > deadline:
                return best, Stop.TIME
            tree = builder.build(usable[np.isin(sensor_of_usable, [*chosen, sensor])])
            trials.append((_rank(problem, tree), sensor, tree))
        rank, sensor, tree = min(trials, key=lambda trial: trial[:2])
        chosen.add(sensor)
        if rank < best_rank:
            best, best_rank = tree, rank
    return best, Stop.FINISHED


def _affordable(problem: Problem, chosen: set[int], useful: set[int]) -> list[int]:
    spent = math.fsum(problem.shape.sensor_costs[sensor] for sensor in chosen)
    return [s for s in sorted(useful - chosen) if spent + problem.shape.sensor_costs[s] <= problem.shape.sensor_limit]


def _rank(problem: Problem, tree: Node) -> tuple[float, int]:
    """Return what trees are ranked by: objective, then complexity."""
    return problem.objective(tree), complexity(tree)
