"""Local search for regression trees: axis-aligned or hyperplane splits, numbers or ridge regressions in the leaves.

A restart draws features within the sensor budget, builds a tree from the root under random weights of the samples, and
improves it: a sweep visits every node once, children first, and keeps the cheapest of three subtrees there.

    the old split between the improved children
    the split that sends each sample to the child that errs less on it, with new leaves (`by_sides`)
    a new subtree, built from this node on (`by_means`)

Sweeps end when one of them gains less than `LEAST_SWEEP_GAIN`. No bound is proven.
"""

import math
import time
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from octmip.trees import _native
from octmip.trees.answer.certificate import checked_incumbent
from octmip.trees.answer.solution import Limits, Progress, ProgressCallback, Solution, Stop
from octmip.trees.methods.options import SearchOptions
from octmip.trees.methods.ordering import ordered
from octmip.trees.methods.pruning import pruned
from octmip.trees.nodes.order import disorder
from octmip.trees.nodes.reached import without_empty_sides
from octmip.trees.nodes.tree import Leaf, Node, complexity
from octmip.trees.question.problem import Problem
from octmip.trees.regression.best_split import Samples, by_means, by_sides, parts
from octmip.trees.regression.leaf_models import constant_of, errors, fitted_leaf

SOLVER = "search"
MOST_SWEEPS = 20
RESTARTS = 10
LEAST_GAIN = 1e-12
"""Share of a subtree's cost that another one must save: less is rounding."""
LEAST_SWEEP_GAIN = 1e-9
"""Share of a tree's cost that a sweep must save for another one to follow."""
SHARE_LEFT_OUT = 0.3
"""Probability that a restart does without a sensor where no budget does so, from the second restart on."""
Rows = NDArray[np.int64]


def search_regression(
    problem: Problem,
    *,
    limits: Limits = Limits(),  # noqa: B008 - frozen
    incumbent: Node | Solution | None = None,
    seed: int = 0,
    n_jobs: int = 1,
    progress: ProgressCallback | None = None,
    options: SearchOptions = SearchOptions(),  # noqa: B008 (frozen)
) -> Solution:
    """Return the best tree that a local search finds, without a bound.

    Parameters
    ----------
    problem
        any regression problem.
    limits
        seconds; nodes are improved nodes.
    incumbent
        a tree of the problem to improve first.
    seed
        of the features and weights that restarts begin with.
    n_jobs
        without effect: the search takes one thread.
    progress
        called with a `Progress` after each sweep over a tree.
    options
        restarts are trees that are built and improved, `RESTARTS` by default.

    Raises
    ------
    ProblemError
        the incumbent is not one of the problem's trees.
    """
    search = _Search(problem, limits, progress, np.random.default_rng(seed))
    start = checked_incumbent(problem, incumbent)
    stop = Stop.FINISHED
    try:
        search.keep(problem.best_leaf())
        if start is not None:
            search.usable = np.unique([j for j in range(problem.samples.n_features) if search.is_affordable(start, j)])
            start = without_empty_sides(start, problem.samples.features)
            search.keep(start)
            search.improve_tree(start)
        for turn in range(RESTARTS if options.restarts is None else options.restarts):
            if search.is_over():
                break
            search.restart(turn)
    except KeyboardInterrupt:
        stop = Stop.INTERRUPTED
    else:
        stop = search.stop
    return search.solution(stop, seed)


@dataclass(slots=True)
class _Search:
    """A search: the best tree so far, the features of this restart, what was spent."""

    problem: Problem
    limits: Limits
    progress: ProgressCallback | None
    rng: np.random.Generator
    started: float = field(default_factory=lambda: time.perf_counter())
    tree: Node | None = None
    cost: float = math.inf
    n_nodes: int = 0
    stop: Stop = Stop.FINISHED
    usable: Rows = field(default_factory=lambda: np.zeros(0, dtype=np.int64))

    @property
    def rows(self) -> Rows:
        """All samples."""
        return np.arange(self.problem.samples.n_samples)

    def is_over(self) -> bool:
        """Whether a limit is reached."""
        if time.perf_counter() - self.started >= self.limits.seconds:
            self.stop = Stop.TIME
        elif self.n_nodes >= self.limits.nodes:
            self.stop = Stop.NODES
        return self.stop is not Stop.FINISHED

    def is_affordable(self, tree: Node, feature: int) -> bool:
        """Whether a tree may read one feature more."""
        shape, sensor = self.problem.shape, self.problem.shape.sensor_index[feature]
        is_paid = shape.sensors[sensor] in shape.sensors_used(tree) or shape.sensor_costs[sensor] == 0.0
        return bool(is_paid or math.isinf(shape.sensor_limit))

    def restart(self, turn: int) -> None:
        """Build a tree over features of its own and improve it."""
        self.usable = self._features(turn)
        n = self.problem.samples.n_samples
        weights = np.ones(n) if turn == 0 else self.rng.exponential(size=n)
        self.improve_tree(self.build(self.rows, self.problem.shape.depth, weights))

    def _features(self, turn: int) -> Rows:
        """Return the features of a restart: of random sensors within the budget, all of them at first without one."""
        problem = self.problem
        left, kept = problem.shape.sensor_limit, set()
        for sensor in self.rng.permutation(len(problem.shape.sensors)).tolist():
            is_left_out = turn > 0 and math.isinf(problem.shape.sensor_limit) and self.rng.random() < SHARE_LEFT_OUT
            if problem.shape.sensor_costs[sensor] <= left and not is_left_out:
                kept.add(sensor)
                left -= problem.shape.sensor_costs[sensor]
        usable = [
            s in kept and problem.shape.is_allowed((f,)) for f, s in enumerate(problem.shape.sensor_index.tolist())
        ]
        groups = problem.shape.allowed_splits
        if groups is None or problem.shape.split == "axis":
            return np.flatnonzero(usable)
        group = groups[int(self.rng.integers(len(groups)))]  # whose features may meet in every split
        return np.intersect1d(np.flatnonzero(usable), np.array(group, dtype=np.int64))

    def build(self, rows: Rows, depth: int, factors: NDArray[np.float64] | None = None) -> Node:
        """Return a tree for some samples, built from the root; `factors` (n_samples,) multiply their weights."""
        problem = self.problem
        leaf = fitted_leaf(problem, rows, self.usable)
        if depth == 0 or len(rows) < max(2, 2 * problem.shape.leaf_size) or not len(self.usable) or self.is_over():
            return leaf
        weights = problem.samples.weights[rows] * (1.0 if factors is None else factors[rows])
        targets = problem.samples.targets[rows]
        targets = targets - constant_of(problem, rows)
        split = Samples(problem, rows, self.usable).best(by_means(weights, targets), weights * targets)
        if split is None:
            return leaf
        left, right = (self.build(part, depth - 1, factors) for part in parts(split, problem.samples.features, rows))
        return self._better(leaf, replace(split, left=left, right=right), rows)

    def _cost(self, node: Node, rows: Rows) -> float:
        return float(errors(self.problem, node, rows).sum()) + self.problem.shape.leaf_penalty * complexity(node)

    def _better(self, known: Node, other: Node, rows: Rows) -> Node:
        """Return the other subtree if it is better by more than rounding."""
        least = self._cost(known, rows)
        return other if self._cost(other, rows) < least - LEAST_GAIN * abs(least) else known

    def improve_tree(self, tree: Node) -> None:
        """Improve the nodes of a tree until none gets better, and keep the tree."""
        before = math.inf
        for _ in range(MOST_SWEEPS):
            tree = self._improved(tree, self.rows, self.problem.shape.depth)
            cost = self._cost(tree, self.rows)
            self.keep(tree)
            if cost >= before * (1 - LEAST_SWEEP_GAIN) or self.is_over():
                return
            before = cost

    def _improved(self, node: Node, rows: Rows, depth: int) -> Node:
        self.n_nodes += 1
        if isinstance(node, Leaf):
            fitted = self._better(node, fitted_leaf(self.problem, rows, self.usable), rows)
            return self._better(fitted, self.build(rows, depth), rows)
        left, right = parts(node, self.problem.samples.features, rows)
        node = replace(
            node, left=self._improved(node.left, left, depth - 1), right=self._improved(node.right, right, depth - 1)
        )
        if self.is_over():
            return node
        costs = [errors(self.problem, side, rows) for side in (node.left, node.right)]
        split = Samples(self.problem, rows, self.usable).best(by_sides(*costs), costs[0] - costs[1])
        if split is not None:
            other = self._refitted(replace(split, left=node.left, right=node.right), rows)
            node = node if other is None else self._better(node, other, rows)
        return self._better(node, self.build(rows, depth), rows)

    def _refitted(self, node: Node, rows: Rows) -> Node | None:
        """Return a subtree with new leaves for the samples that reach them now; None where a leaf is too small."""
        if isinstance(node, Leaf):
            return None if len(rows) < self.problem.shape.leaf_size else fitted_leaf(self.problem, rows, self.usable)
        sides = zip((node.left, node.right), parts(node, self.problem.samples.features, rows), strict=True)
        left, right = (self._refitted(side, part) for side, part in sides)
        return None if left is None or right is None else replace(node, left=left, right=right)

    def keep(self, tree: Node) -> None:
        """Take up a tree, pruned and in order where that is asked for, if it is better than the best so far."""
        tree = pruned(self.problem, tree, self.problem.shape.max_splits)
        if self.problem.shape.monotone is not None and disorder(tree, self.problem.shape.directions) is not None:
            tree = ordered(self.problem, self.problem.with_best_leaves(tree))
        cost = self._cost(tree, self.rows)
        if cost < self.cost:
            self.tree, self.cost = tree, cost
        if self.progress is not None:
            self.progress(Progress(time.perf_counter() - self.started, self.cost, -math.inf, self.n_nodes))

    def solution(self, stop: Stop, seed: int) -> Solution:
        """Return the best tree, constants rounded once, its objective recounted."""
        assert self.tree is not None
        problem = self.problem
        is_settled = problem.shape.leaf_model == "linear" or problem.shape.monotone is not None
        tree = self.tree if is_settled else problem.with_best_leaves(self.tree)
        seconds, objective = time.perf_counter() - self.started, problem.objective(tree)
        version = _native.__version__
        return Solution(tree, objective, -math.inf, stop, seconds, self.n_nodes, SOLVER, version, seed)
