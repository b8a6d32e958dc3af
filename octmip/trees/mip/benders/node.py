"""One node: the cheapest cuts of the master are answered below, until none is left that may be better than the best.

A round takes the cheapest cut of each of the `ROUND` cheapest features, so that its subproblems can run side by side;
what they teach is learnt after the round, in its order. So the search is the same for any number of threads.
"""

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from octmip.errors import CertificateError
from octmip.trees.answer.certificate import checked_leaf_index
from octmip.trees.mip.benders.bounds import Bounds
from octmip.trees.mip.benders.cuts import Cut
from octmip.trees.mip.benders.master import Master
from octmip.trees.mip.benders.memory import Memory
from octmip.trees.mip.benders.subproblem import Answer, Subproblem
from octmip.trees.mip.blocks import axis
from octmip.trees.nodes.tree import Leaf, Node, Split, leaf_index, leaves
from octmip.trees.question.problem import Problem

ROUND = 4
"""Cuts of one round. Measured on mu2, 1750 x 20, depth 2: 617 subproblems with one cut, 616 with four."""

TIE = 0.4
"""Prices are whole, so less than half a price orders the cuts of one price and no others. Measured on mu1, 350 rows,
depth 3: 3,234 subproblems with the innermost cut of a run first, 9,652 without."""


@dataclass(frozen=True, slots=True, eq=False)
class Lesson:
    """What a subproblem teaches: no tree for these samples is cheaper (`Bounds.learn`)."""

    samples: NDArray[np.bool_]
    price: float
    within: bool


@dataclass(frozen=True, slots=True, eq=False)
class Evaluated:
    """A cut whose sides were answered: the lessons, the tree where both have one, the price of both sides together."""

    cut: Cut
    lessons: tuple[Lesson, ...]
    memory: Memory
    tree: Node | None
    both: float = 0.0


Answerer = Callable[[Subproblem, Memory], Answer]
"""Answers the subproblem of a side, and adds to the memory."""
Together = Callable[[Subproblem, Cut, Node], Answer]
"""Answers a subproblem for the trees that make a cut at the root, or are the tree given."""
Tasks = Callable[[list[Callable[[], Evaluated]]], Iterable[Evaluated]]
"""Runs tasks, side by side or in turn, and returns their results in order."""


@dataclass(slots=True, eq=False)
class NodeSearch:
    """The search for the best tree of a subproblem; its state can be read at any time."""

    subproblem: Subproblem
    answer: Answerer
    together: Together
    best: Node
    price: float
    leaf: float
    bounds: Bounds
    memory: Memory
    tried: NDArray[np.bool_]

    @classmethod
    def of(
        cls, subproblem: Subproblem, best: Node, answer: Answerer, together: Together, memory: Memory
    ) -> "NodeSearch":
        """Return the search before its first round, with the bounds of class counts and of the memory."""
        problem, prices = subproblem.problem, subproblem.prices
        bounds = Bounds.of_class_counts(problem, prices)
        if problem.shape.sensor_budget is None:  # with one, a value holds for one sensor above only
            for samples, price in memory.recall(subproblem):
                bounds.learn(samples, price)
        leaf = float(prices.of_labels(np.arange(problem.samples.n_samples)).min())
        tried = np.zeros(len(bounds.cuts.feature), dtype=bool)
        return cls(subproblem, answer, together, best, prices.of_tree(problem, best), leaf, bounds, memory, tried)

    @property
    def bound(self) -> float:
        """No tree of the subproblem is cheaper."""
        return min(self.price, self.leaf, float(self.bounds.price.min(initial=math.inf)))

    @property
    def result(self) -> Answer:
        """The answer as far as it is known."""
        return Answer(self.best, self.price, self.bound)

    def run(self, tasks: Tasks, after_round: Callable[[], bool] = lambda: False) -> Answer:
        """Search until the answer is proven, the target is reached, or `after_round` wants an end."""
        master = Master(self.bounds, self.leaf, min(self.price, self.subproblem.target))
        while True:
            goal = min(self.price, self.subproblem.target)
            price = np.where(self.tried, math.inf, self.bounds.price)
            order = TIE / (1 + self.bounds.depth_in_run(price < goal))
            places = master.cheapest(price, goal, ROUND, order)
            if not places:
                return self.result
            for evaluated in tasks([partial(self._evaluated, self.bounds.cut(place), goal) for place in places]):
                self._learn(evaluated)
            if after_round():
                return self.result

    def _learn(self, evaluated: Evaluated) -> None:
        cut, problem = evaluated.cut, self.subproblem.problem
        sensor = int(problem.shape.sensor_index[cut.feature]) if math.isfinite(problem.shape.sensor_limit) else None
        for lesson in evaluated.lessons:
            self.bounds.learn(lesson.samples, lesson.price, within=lesson.within, sensor=sensor)
        self.bounds.both[cut.place] = max(self.bounds.both[cut.place], evaluated.both)
        self.tried[cut.place] = True
        self.memory.merge(evaluated.memory)
        if evaluated.tree is not None:
            price = self.subproblem.prices.of_tree(problem, evaluated.tree)
            if price < self.price:
                self.best, self.price = evaluated.tree, price

    def _evaluated(self, cut: Cut, goal: float) -> Evaluated:
        """Answer the left side of a cut, then the right one unless the cut is already too expensive."""
        left = self.bounds.is_left(cut)
        room = goal - self.subproblem.prices.penalty
        lessons: list[Lesson] = []
        memory = self.memory.branch()
        on_left = self._side(cut, left, room - self.bounds.right[cut.place], lessons, memory)
        if on_left.bound + self.bounds.right[cut.place] >= room:
            return Evaluated(cut, tuple(lessons), memory, None)
        on_right = self._side(cut, ~left, room - on_left.bound, lessons, memory)
        tree = Split(
            cut.feature, axis.threshold_at(cut.feature, cut.rank, self.bounds.ranks), on_left.tree, on_right.tree
        )
        if self._fits(tree):
            return Evaluated(cut, tuple(lessons), memory, tree)
        if on_left.bound + on_right.bound >= room:
            return Evaluated(cut, tuple(lessons), memory, None)
        half = replace(tree, right=_leaf_answer(self.subproblem, ~left).tree)
        both = self.together(self.subproblem, cut, half)  # a budget joins the sides: one model for the two
        return Evaluated(cut, tuple(lessons), memory, both.tree, both.bound - self.subproblem.prices.penalty)

    def _fits(self, tree: Node) -> bool:
        try:
            checked_leaf_index(self.subproblem.problem, tree)
        except CertificateError:
            return False
        return True

    def _side(
        self, cut: Cut, samples: NDArray[np.bool_], target: float, lessons: list[Lesson], memory: Memory
    ) -> Answer:
        """Answer one side of a cut; without its leaf size first, as that bounds other cuts' sides too."""
        at_leaf = _leaf_answer(self.subproblem, samples)
        if at_leaf.is_proven:
            lessons.append(Lesson(samples, at_leaf.bound, within=True))
            return at_leaf
        subproblem = _side_of(self.subproblem, samples, cut.feature, target)
        problem = subproblem.problem
        if problem.shape.leaf_size == 1:
            found = self.answer(subproblem, memory)
            memory.add(problem.shape.depth, subproblem.rows, found.bound)
            lessons.append(Lesson(samples, found.bound, within=False))
            return found
        free = self.answer(replace(subproblem, problem=problem.replace(leaf_size=1)), memory)
        memory.add(problem.shape.depth, subproblem.rows, free.bound)
        lessons.append(Lesson(samples, free.bound, within=False))
        if free.bound >= target or _holds_leaf_size(problem, free.tree):
            return free
        found = self.answer(subproblem, memory)
        lessons.append(Lesson(samples, found.bound, within=True))
        return found


def _leaf_answer(subproblem: Subproblem, samples: NDArray[np.bool_]) -> Answer:
    """Return the answer of one leaf for some samples: proven where no split can help or none fits."""
    rows, prices = np.flatnonzero(samples), subproblem.prices
    by_label = prices.of_labels(rows)
    label = int(by_label.argmin())
    price = float(by_label[label])
    least = float((prices.weights[rows] * prices.costs[prices.profile[rows]].min(axis=1)).sum())
    is_one_class = bool((subproblem.problem.samples.codes[rows] == subproblem.problem.samples.codes[rows[0]]).all())
    is_final = is_one_class or least >= price or len(rows) < 2 * subproblem.problem.shape.leaf_size
    return Answer(Leaf(label), price, price if is_final else least)


def _side_of(subproblem: Subproblem, samples: NDArray[np.bool_], feature: int, target: float) -> Subproblem:
    """Return the subproblem of the samples on one side of a cut: one level less, the cut's sensor paid for."""
    problem, prices = subproblem.problem, subproblem.prices
    inside = problem.of_rows(samples, depth=problem.shape.depth - 1, **_budget_below(problem, feature))
    inside_prices = replace(prices, weights=prices.weights[samples], profile=prices.profile[samples])
    return Subproblem(inside, inside_prices, subproblem.rows[samples], target)


def _budget_below(problem: Problem, feature: int) -> dict[str, Any]:
    """Return sensor costs and budget below a cut: its own sensor is free, and what is paid for it is gone."""
    shape = problem.shape
    if shape.sensor_budget is None:
        return {}
    costs, sensor = shape.sensor_costs.copy(), int(shape.sensor_index[feature])
    left = max(0.0, shape.sensor_limit - float(costs[sensor]))
    costs[sensor] = 0.0
    return {"sensor_cost": costs, "sensor_budget": left}


def _holds_leaf_size(problem: Problem, tree: Node) -> bool:
    """Whether every leaf of a tree holds as many samples as the problem wants."""
    counts = np.bincount(leaf_index(tree, problem.samples.features), minlength=len(leaves(tree)))
    return bool(counts.min() >= problem.shape.leaf_size)
