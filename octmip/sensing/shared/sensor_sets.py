"""Branch and bound over sets of sensors: the best trees of several labels under one budget, proven.

A node holds some sensors (paid for, free to all labels) and bans others. Its bound is the sum over labels of
weight * z_label(held, banned), see `octmip.sensing.shared.label_trees`: every label may spend all that is left as if it
were alone, so nothing below the node costs less. Where the labels' trees keep the budget together the bound is met and
the node closed; else a sensor that is read but not held is held in one child and banned in the other. Every child
decides one sensor more, and trees that read held sensors alone keep the budget: so it ends. Nodes are taken least bound
first.

A child is narrower than its parent. So a parent's tree that is still possible in the child is the child's solution too,
bound and all, without a solve; and a label's bound is never below its parent's.
"""

import heapq
import math
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field, replace

from octmip.sensing.shared.label_trees import NONE, LabelTrees, Sensors
from octmip.sensing.shared.solution import weighted_sum
from octmip.trees.solution import Solution, Stop
from octmip.trees.tree import Node


@dataclass(frozen=True, slots=True, order=True)
class _Set:
    """A node: held and banned sensors, each label's solution, and the weighted sum of their bounds."""

    bound: float
    number: int  # of its creation: of equal bounds the older comes first
    held: Sensors = field(compare=False)
    banned: Sensors = field(compare=False)
    solutions: tuple[Solution, ...] = field(compare=False)


@dataclass(frozen=True, slots=True)
class Proof:
    """The result of the search over sets: no trees that keep the budget have a weighted sum below `bound`.

    Attributes
    ----------
    bound
        of the weighted sum.
    stop
        why the search ended.
    n_nodes
        sets of sensors that were branched on.
    own_bounds
        (n_labels,) bound of each label with the whole budget for itself.
    tolerance
        how far bound and objective may stand apart and still meet.
    """

    bound: float
    stop: Stop
    n_nodes: int
    own_bounds: tuple[float, ...]
    tolerance: float


def least_saving(labels: LabelTrees) -> float:
    """Return the least saving of the weighted sum by one sample or split of one label."""
    pairs = zip(labels.weights, labels.problems, strict=True)
    return min(weight * problem.least_saving for weight, problem in pairs if weight > 0)


@dataclass(slots=True)
class SetSearch:
    """The search over sets; the incumbent is `labels.best`."""

    labels: LabelTrees
    open: list[_Set] = field(default_factory=list)
    closed: float = math.inf  # least bound of what was closed
    tolerance: float = 0.0
    n_created: int = 0
    n_nodes: int = 0

    def run(self) -> Proof:
        """Search until nothing is open, or a limit is reached."""
        n_labels = len(self.labels.problems)
        root = tuple(self.labels.solve(label, NONE, NONE) for label in range(n_labels))
        self.labels.alternate(self._repaired(NONE, NONE, root))
        self._enter(NONE, NONE, root)
        while self.open and not self._is_done():
            self._branch(heapq.heappop(self.open))
        best = self.labels.best.objective
        bound = min(self.closed, best, *(node.bound for node in self.open))
        # What rounding hides in one label must be less than a sample of any label is worth in the sum.
        tolerance = self.tolerance if self.tolerance < least_saving(self.labels) else 0.0
        stop = self._early_stop() if bound < best - tolerance or self.labels.is_interrupted else Stop.OPTIMAL
        return Proof(bound, stop, self.n_nodes, tuple(solution.bound for solution in root), tolerance)

    def _is_done(self) -> bool:
        best, least = self.labels.best.objective, self.open[0].bound
        is_near = best - least <= max(self.tolerance, self.labels.run.limits.gap * best)
        return is_near or self.labels.is_over or self.n_nodes >= self.labels.run.limits.nodes

    def _early_stop(self) -> Stop:
        if self.labels.is_interrupted:
            return Stop.INTERRUPTED
        if self.labels.is_over:
            return Stop.TIME
        if self.open:
            return Stop.NODES if self.n_nodes >= self.labels.run.limits.nodes else Stop.GAP
        # Some solution lacks its proof, and not for lack of time.
        stops = {solution.stop for solution in self.labels.known.values()}
        return Stop.MEMORY if Stop.MEMORY in stops else Stop.NUMERICS

    def _branch(self, node: _Set) -> None:
        """Decide on one sensor: first the child in which it is banned, then the one in which it is held."""
        self.n_nodes += 1
        sensor = self._undecided(node)
        for held, banned in ((node.held, node.banned | {sensor}), (node.held | {sensor}, node.banned)):
            if self.labels.is_affordable(held):
                solutions = self._solutions(node, held, banned)
                if solutions is not None:
                    self._enter(held, banned, solutions)

    def _undecided(self, node: _Set) -> str:
        """Return the sensor to decide on: read by the fewest labels, then the most expensive, then the first by name.

        Held, it takes money from all the labels that do not read it; banned, it takes itself from those that do.
        """
        readers = Counter(
            name for label, a in enumerate(node.solutions) for name in self._sensors(label, a) - node.held
        )
        return min(readers, key=lambda name: (readers[name], -self.labels.prices[name], name))

    def _sensors(self, label: int, solution: Solution) -> Sensors:
        assert solution.tree is not None  # the exact core always returns one
        return frozenset(self.labels.problems[label].sensors_used(solution.tree))

    def _solutions(self, parent: _Set, held: Sensors, banned: Sensors) -> tuple[Solution, ...] | None:
        """Return each label's solution in a child; None, the child closed, once their bounds reach the incumbent."""
        solutions = list(parent.solutions)
        for label, known in enumerate(parent.solutions):
            assert known.tree is not None
            if self.labels.is_possible(label, known.tree, held, banned):
                continue
            found = self.labels.solve(label, held, banned)
            solutions[label] = replace(found, bound=max(found.bound, min(known.bound, found.objective)))
            bound = self._bound(solutions)
            if bound >= self.labels.best.objective - self.tolerance:
                self.closed = min(self.closed, bound)
                return None
        return tuple(solutions)

    def _bound(self, solutions: Sequence[Solution]) -> float:
        return weighted_sum(self.labels.weights, (solution.bound for solution in solutions))

    def _enter(self, held: Sensors, banned: Sensors, solutions: tuple[Solution, ...]) -> None:
        """Close a node whose trees keep the budget together, put another among the open ones."""
        tolerances = (solution.tolerance for solution in solutions)
        self.tolerance = max(self.tolerance, weighted_sum(self.labels.weights, tolerances))
        trees = [solution.tree for solution in solutions if solution.tree is not None]
        bound = self._bound(solutions)
        self.labels.offer(trees)
        if self.labels.is_affordable(self.labels.sensors_of(trees)):
            self.closed = min(self.closed, bound)
            return
        self.labels.offer(self._repaired(held, banned, solutions))
        self.n_created += 1
        heapq.heappush(self.open, _Set(bound, self.n_created, held, banned, solutions))

    def _repaired(self, held: Sensors, banned: Sensors, solutions: Sequence[Solution]) -> tuple[Node, ...]:
        """Return trees that keep the budget: of the sensors read, those of most labels first while they can be paid."""
        readers = Counter(
            name for label, solution in enumerate(solutions) for name in self._sensors(label, solution) - held
        )
        bought = set(held)
        for name in sorted(readers, key=lambda name: (-readers[name], self.labels.prices[name], name)):
            if self.labels.is_affordable(bought | {name}):
                bought.add(name)
        rest = frozenset(self.labels.prices) - bought
        found = (self.labels.solve(label, frozenset(bought), rest) for label in range(len(solutions)))
        return tuple(solution.tree for solution in found if solution.tree is not None)
