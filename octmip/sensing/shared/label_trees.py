"""The best tree of one label while some sensors are paid for, some banned, and the rest must fit the budget left.

    z_l(H, B) = min objective_l(T)   over trees T that read no sensor of B, sensors outside H costing `left` at most

H is held: bought already, so free. Where the trees of all labels keep the budget together, their sum is the best for
(H, B); in any case sum_l weight_l z_l(H, B) bounds it from below, as each label is given all that is left for itself.
"""

import math
import time
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace

from octmip.sensing.shared.solution import weighted_sum
from octmip.trees.problem import Problem
from octmip.trees.registry import Run
from octmip.trees.solution import Limits, Solution, Stop
from octmip.trees.solver import solve_run
from octmip.trees.tree import Leaf, Node

Sensors = frozenset[str]
NONE: Sensors = frozenset()


@dataclass(frozen=True, slots=True)
class JointTrees:
    """Trees that keep the budget together, and their weighted sum."""

    trees: tuple[Node, ...]
    objective: float


@dataclass(slots=True)
class LabelTrees:
    """The values z_l(H, B) of every label, each computed once, and the best trees that keep the budget.

    Attributes
    ----------
    problems
        one per label, `sensor_budget` the shared one.
    weights
        (n_labels,).
    prices
        of the sensors by name.
    run
        method, limits, seed, threads and options of every solve; the limits hold for all together.
    best
        the best trees known so far.
    started
        when the clock began, by `time.perf_counter`.
    is_interrupted
        whether Ctrl-C was pressed.
    known
        the solutions so far, by label, held and banned sensors.
    """

    problems: tuple[Problem, ...]
    weights: tuple[float, ...]
    prices: Mapping[str, float]
    run: Run
    best: JointTrees
    started: float = field(default_factory=time.perf_counter)
    is_interrupted: bool = False
    known: dict[tuple[int, Sensors, Sensors], Solution] = field(default_factory=dict)

    @property
    def is_over(self) -> bool:
        """Whether time is up or Ctrl-C was pressed."""
        return self.is_interrupted or time.perf_counter() >= self.started + self.run.limits.seconds

    @property
    def remaining(self) -> Limits:
        """Limits of the next solve: the time that is left."""
        seconds = max(0.0, self.started + self.run.limits.seconds - time.perf_counter())
        return Limits(seconds=seconds, memory=self.run.limits.memory)

    def cost(self, sensors: Iterable[str]) -> float:
        """Return the cost of the sensors together."""
        return math.fsum(self.prices[name] for name in sensors)

    def is_affordable(self, sensors: Iterable[str]) -> bool:
        """Whether sensors keep the budget together."""
        return self.cost(sensors) <= self.problems[0].sensor_limit

    def solve(self, label: int, held: Sensors, banned: Sensors, start: Node | None = None) -> Solution:
        """Return the solution of z_label(held, banned)."""
        own = frozenset(self.problems[label].sensors)
        question = label, held, banned & own
        if question not in self.known or (start is not None and self.run.method == "search"):
            asked = self._asked(label, held, banned)
            solution = solve_run(asked, replace(self.run, limits=self.remaining), start)
            self.is_interrupted |= solution.stop is Stop.INTERRUPTED
            self.known[question] = solution
        return self.known[question]

    def _asked(self, label: int, held: Sensors, banned: Sensors) -> Problem:
        """Return the problem of a question: held sensors are free, banned ones cost more than all that is left."""
        problem = self.problems[label]
        assert problem.sensor_budget is not None  # the shared one
        left = max(0.0, problem.sensor_budget - self.cost(held))
        prices = {
            name: 0.0 if name in held else 2 * left + 1 if name in banned else self.prices[name]
            for name in problem.sensors
        }
        return replace(problem, sensor_cost=prices, sensor_budget=left)

    def is_possible(self, label: int, tree: Node, held: Sensors, banned: Sensors) -> bool:
        """Whether a label's tree is possible for z_label(held, banned) as well."""
        used = self._read(label, tree)
        return not used & banned and self.is_affordable(used | held)

    def leaf(self, label: int) -> Node:
        """Return a label's best tree without a sensor."""
        return Leaf(int(self.problems[label].class_costs().argmin()))

    def sensors_of(self, trees: Sequence[Node]) -> Sensors:
        """Return the sensors that some of the trees reads."""
        return NONE.union(*(self._read(label, tree) for label, tree in enumerate(trees)))

    def _read(self, label: int, tree: Node) -> Sensors:
        return frozenset(self.problems[label].sensors_used(tree))

    def offer(self, trees: Sequence[Node]) -> bool:
        """Keep these trees if they keep the budget and are better than the best so far; return whether they are."""
        if not self.is_affordable(self.sensors_of(trees)):
            return False
        values = (p.objective(t) for p, t in zip(self.problems, trees, strict=True))
        objective = weighted_sum(self.weights, values)
        if objective < self.best.objective:
            self.best = JointTrees(tuple(trees), objective)
            return True
        return False

    def alternate(self, trees: Sequence[Node]) -> tuple[Node, ...]:
        """Return trees no worse, one label after the other found again: sensors of the others free, the rest left."""
        current, is_better = list(trees), True
        while is_better and not self.is_over:
            is_better = False
            for label, problem in enumerate(self.problems):
                held = NONE.union(*(self._read(k, tree) for k, tree in enumerate(current) if k != label))
                before = problem.objective(current[label])
                found = self.solve(label, held, NONE, current[label])
                if found.tree is not None and found.objective < before:
                    current[label], is_better = found.tree, True
        self.offer(current)
        return tuple(current)
