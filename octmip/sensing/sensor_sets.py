"""The search for trees of several labels under one budget of sensors, each sensor paid for once.

Every question is one Problem of one label: z_l(H, B) is the optimum of label l where sensors H are held (paid for, so
free), sensors B are banned, and all that is left of the budget is its own. So sum_l weight_l z_l(H, B) bounds the joint
sum below. A search over sets, least bound first, takes a sensor that is read but not held, and bans it in one child and
holds it in the other; a set whose trees keep the budget together is closed. Trees are improved in turn, the sensors of
the others held.
"""

import heapq
import math
import time
from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace
from typing import Literal

from octmip.errors import ProblemError
from octmip.sensing.joint_solution import (
    JointSolution,
    certify_joint,
    least_saving,
    sensor_prices,
    sensors_of,
    weighted_sum,
)
from octmip.trees.answer.solution import Limits, Solution, Stop
from octmip.trees.methods.options import NO_OPTIONS, Options
from octmip.trees.nodes.tree import Leaf, Node
from octmip.trees.question.problem import Problem
from octmip.trees.runs.registry import Run, refuse_unknown
from octmip.trees.solver import solve_run

JointMethod = Literal["auto", "exact", "search"]
EXACT_DEPTH = 3  # "auto" proves to this depth; a proof of one label takes a second there, and there are many
Sensors = frozenset[str]
NONE: Sensors = frozenset()


def shared_budget(
    problems: Sequence[Problem],
    budget: float,
    *,
    weights: Sequence[float] | None = None,
    method: JointMethod = "auto",
    limits: Limits = Limits(),  # noqa: B008 (frozen)
    seed: int = 0,
    n_jobs: int = 1,
    options: Options = NO_OPTIONS,
) -> JointSolution:
    """Return one tree for each problem, all within one budget of sensors, and the bound of their weighted sum.

    Parameters
    ----------
    problems
        one per label, without budgets of their own. Sensors of one name are one sensor and have one cost. Depth, kind
        of split, weights and costs may differ.
    budget
        of all sensors that some tree reads, each paid for once.
    weights
        of the labels' objectives in the sum; None: all 1.
    method
        "exact" (axis-aligned trees) proves; "search" does not; "auto" is exact to depth 3, else search.
    limits
        wall seconds, relative gap, nodes (sets of sensors) and memory of all together.
    seed, n_jobs, options
        of every solve; options are the method's own, for instance ``restarts`` of the search.

    Raises
    ------
    ProblemError
        there is no problem, one has a budget of its own, a sensor has two costs, weights or method do
        not fit.
    SolverError
        a solver failed.

    Examples
    --------
    >>> problems = [Problem([[0, 5], [1, 5], [2, 7]], y, depth=1) for y in (["a", "b", "b"], ["c", "d", "c"])]
    >>> shared_budget(problems, budget=1).sensors
    ('x0',)
    """
    for problem in problems:
        refuse_unknown(problem, "shared_budget")
    shared, shares = _with_budget(problems, budget), _checked_weights(weights, len(problems))
    run = Run(_chosen_method(shared, method), limits, seed, n_jobs, options)
    joint = SetSearch(shared, shares, run).found()
    certify_joint(joint)
    return joint


def _with_budget(problems: Sequence[Problem], budget: float) -> tuple[Problem, ...]:
    if not problems:
        raise ProblemError("problems is empty; expected one problem for each label; give one")
    budgeted = [k for k, problem in enumerate(problems) if problem.shape.sensor_budget is not None]
    if budgeted:
        raise ProblemError(
            f"problems {budgeted} have a sensor_budget of their own; expected none, as the shared "
            "one holds for all; leave it out"
        )
    return tuple(problem.replace(sensor_budget=budget) for problem in problems)


def _checked_weights(weights: Sequence[float] | None, n_labels: int) -> tuple[float, ...]:
    shares = (1.0,) * n_labels if weights is None else tuple(float(weight) for weight in weights)
    if len(shares) != n_labels or not all(math.isfinite(share) and share >= 0 for share in shares) or not any(shares):
        raise ProblemError(
            f"weights is {weights}; expected {n_labels} finite numbers of 0 or more, not all 0: one for each problem"
        )
    return shares


def _chosen_method(problems: Sequence[Problem], method: str) -> Literal["exact", "search"]:
    if method not in ("auto", "exact", "search"):
        raise ProblemError(f"method is {method!r}; expected 'auto', 'exact' or 'search'")
    is_axis = all(problem.shape.split == "axis" for problem in problems)
    if method == "exact" and not is_axis:
        raise ProblemError("method is 'exact' but a problem asks for hyperplanes; use 'search', or split='axis'")
    is_small = is_axis and max(problem.shape.depth for problem in problems) <= EXACT_DEPTH
    return "exact" if method == "exact" or (method == "auto" and is_small) else "search"


@dataclass(frozen=True, slots=True, order=True)
class _Set:
    """Held and banned sensors, each label's solution there, and the weighted sum of their bounds."""

    bound: float
    number: int  # of its creation: of equal bounds the older comes first
    held: Sensors = field(compare=False)
    banned: Sensors = field(compare=False)
    solutions: tuple[Solution, ...] = field(compare=False)


class SetSearch:
    """The search over sets of sensors.

    Attributes
    ----------
    best, objective
        the best trees so far that keep the budget together, and their weighted sum; leaves at first.
    known
        the solutions so far by label, held and banned sensors.
    open, closed
        sets to be branched on; the least bound of those that need not be.
    """

    def __init__(self, problems: tuple[Problem, ...], weights: tuple[float, ...], run: Run) -> None:
        self.problems, self.weights, self.run, self.prices = problems, weights, run, sensor_prices(problems)
        self.started, self.is_interrupted = time.perf_counter(), False
        self.best: tuple[Node, ...] = tuple(Leaf(int(problem.class_costs().argmin())) for problem in problems)
        self.objective = self._value(self.best)
        self.known: dict[tuple[int, Sensors, Sensors], Solution] = {}
        self.open: list[_Set] = []
        self.closed, self.tolerance, self.n_created, self.n_nodes = math.inf, 0.0, 0, 0

    def found(self) -> JointSolution:
        """Return the best trees, with their bound where the method proves one."""
        leaves, alone = self.best, tuple(self._solution(label, NONE, NONE) for label in range(len(self.problems)))
        self._alternate(self._repaired(alone))
        if self.run.method == "search":
            for label, first in enumerate(alone):  # whose sensors are bought first
                self._alternate([*leaves[:label], first.tree or leaves[label], *leaves[label + 1 :]])
        bound, stop = self._proven(alone) if self.run.method == "exact" else self._improved()
        bounds = [solution.bound if self.run.method == "exact" else bound for solution in alone]
        return JointSolution(
            problems=self.problems,
            weights=self.weights,
            solutions=tuple(map(self._claim, self.problems, self.best, alone, bounds)),
            bound=bound,
            stop=stop,
            seconds=time.perf_counter() - self.started,
            n_nodes=self.n_nodes,
            tolerance=self.tolerance,
        )

    def _claim(self, problem: Problem, tree: Node, alone: Solution, bound: float) -> Solution:
        """Return a label's tree as a solution of its problem; its bound is one for this label alone."""
        objective = problem.objective(tree)
        return replace(
            alone,
            tree=tree,
            objective=objective,
            bound=min(bound, objective),
            stop=Stop.OPTIMAL if bound >= objective else Stop.FINISHED,
            tolerance=0.0,
            details={},
        )

    # One label

    def _solution(self, label: int, held: Sensors, banned: Sensors, start: Node | None = None) -> Solution:
        """Return the solution of z_label(held, banned): held sensors free, banned ones dearer than all that is left."""
        problem = self.problems[label]
        question = label, held, banned & frozenset(problem.shape.sensors)
        if question not in self.known or (start is not None and self.run.method == "search"):
            assert problem.shape.sensor_budget is not None  # the shared one
            left = max(0.0, problem.shape.sensor_budget - self._cost(held))
            prices = {
                name: 0.0 if name in held else 2 * left + 1 if name in banned else self.prices[name]
                for name in problem.shape.sensors
            }
            seconds = max(0.0, self.started + self.run.limits.seconds - time.perf_counter())
            limits = Limits(seconds=seconds, memory=self.run.limits.memory)
            asked = problem.replace(sensor_cost=prices, sensor_budget=left)
            solution = solve_run(asked, replace(self.run, limits=limits), start)
            self.is_interrupted |= solution.stop is Stop.INTERRUPTED
            self.known[question] = solution
        return self.known[question]

    def _read(self, label: int, tree: Node | None) -> Sensors:
        assert tree is not None  # both methods always return one
        return frozenset(self.problems[label].shape.sensors_used(tree))

    def _cost(self, sensors: Iterable[str]) -> float:
        return math.fsum(self.prices[name] for name in sensors)

    def _is_affordable(self, sensors: Iterable[str]) -> bool:
        return self._cost(sensors) <= self.problems[0].shape.sensor_limit

    @property
    def _is_over(self) -> bool:
        return self.is_interrupted or time.perf_counter() >= self.started + self.run.limits.seconds

    # Trees of all labels

    def _value(self, trees: Sequence[Node]) -> float:
        return weighted_sum(self.weights, (p.objective(tree) for p, tree in zip(self.problems, trees, strict=True)))

    def _offer(self, trees: Sequence[Node]) -> None:
        """Keep trees that keep the budget and are better than the best so far."""
        if self._is_affordable(sensors_of(self.problems, trees)) and self._value(trees) < self.objective:
            self.best, self.objective = tuple(trees), self._value(trees)

    def _alternate(self, trees: Sequence[Node]) -> None:
        """Offer trees no worse than these, one label after the other found again with the sensors of the others."""
        current, is_better = list(trees), True
        while is_better and not self._is_over:
            is_better = False
            for label, problem in enumerate(self.problems):
                held = NONE.union(*(self._read(k, tree) for k, tree in enumerate(current) if k != label))
                found = self._solution(label, held, NONE, current[label])
                if found.tree is not None and found.objective < problem.objective(current[label]):
                    current[label], is_better = found.tree, True
        self._offer(current)

    def _repaired(self, solutions: Sequence[Solution], held: Sensors = NONE) -> tuple[Node, ...]:
        """Return trees that keep the budget: of the sensors read, those of most labels first while they can be paid."""
        readers = Counter(name for k, one in enumerate(solutions) for name in self._read(k, one.tree) - held)
        bought = set(held)
        for name in sorted(readers, key=lambda name: (-readers[name], self.prices[name], name)):
            if self._is_affordable(bought | {name}):
                bought.add(name)
        rest = frozenset(self.prices) - bought
        found = (self._solution(label, frozenset(bought), rest).tree for label in range(len(solutions)))
        return tuple(tree for tree in found if tree is not None)

    def _improved(self) -> tuple[float, Stop]:
        """Give up each sensor in turn and take turns again, until none is worth giving up; no bound but 0."""
        is_better = True
        while is_better and not self._is_over:
            before, is_better = self.objective, False
            for sensor in sorted(sensors_of(self.problems, self.best)):
                kept = sensors_of(self.problems, self.best) - {sensor}
                banned = frozenset(self.prices) - kept
                trees = (self._solution(k, kept, banned).tree for k in range(len(self.problems)))
                self._alternate([tree for tree in trees if tree is not None])
                is_better |= self.objective < before
        if self.objective == 0:
            return 0.0, Stop.OPTIMAL
        return -math.inf, self._early_stop() if self._is_over else Stop.FINISHED

    # The proof

    def _proven(self, root: tuple[Solution, ...]) -> tuple[float, Stop]:
        """Search until nothing is open, or a limit is reached; return the bound of the sum and why it stopped."""
        self._enter(NONE, NONE, root)
        while self.open and not self._is_done():
            self._branch(heapq.heappop(self.open))
        bound = min(self.closed, self.objective, *(one.bound for one in self.open))
        # What rounding hides in one label must be less than a sample of any label is worth in the sum.
        self.tolerance *= self.tolerance < least_saving(self.problems, self.weights)
        is_early = bound < self.objective - self.tolerance or self.is_interrupted
        return bound, self._early_stop() if is_early else Stop.OPTIMAL

    def _is_done(self) -> bool:
        is_near = self.objective - self.open[0].bound <= max(self.tolerance, self.run.limits.gap * self.objective)
        return is_near or self._is_over or self.n_nodes >= self.run.limits.nodes

    def _early_stop(self) -> Stop:
        if self._is_over:
            return Stop.INTERRUPTED if self.is_interrupted else Stop.TIME
        if self.open:
            return Stop.NODES if self.n_nodes >= self.run.limits.nodes else Stop.GAP
        # Some solution lacks its proof, and not for lack of time.
        return Stop.MEMORY if Stop.MEMORY in {one.stop for one in self.known.values()} else Stop.NUMERICS

    def _branch(self, parent: _Set) -> None:
        """Decide on a sensor that is read by the fewest labels, then the dearest: ban it, then hold it."""
        self.n_nodes += 1
        readers = Counter(n for k, one in enumerate(parent.solutions) for n in self._read(k, one.tree) - parent.held)
        sensor = min(readers, key=lambda name: (readers[name], -self.prices[name], name))
        for held, banned in ((parent.held, parent.banned | {sensor}), (parent.held | {sensor}, parent.banned)):
            if self._is_affordable(held):
                self._solve_child(parent, held, banned)

    def _solve_child(self, parent: _Set, held: Sensors, banned: Sensors) -> None:
        """Enter a child, or close it once the bounds of its labels reach the best trees.

        A child is narrower than its parent: a tree of the parent's that is still possible is the child's solution too,
        bound and all, and no bound is below the parent's.
        """
        solutions = list(parent.solutions)
        for label, known in enumerate(parent.solutions):
            used = self._read(label, known.tree)
            if not used & banned and self._is_affordable(used | held):
                continue
            found = self._solution(label, held, banned)
            solutions[label] = replace(found, bound=max(found.bound, min(known.bound, found.objective)))
            bound = weighted_sum(self.weights, (solution.bound for solution in solutions))
            if bound >= self.objective - self.tolerance:
                self.closed = min(self.closed, bound)
                return
        self._enter(held, banned, tuple(solutions))

    def _enter(self, held: Sensors, banned: Sensors, solutions: tuple[Solution, ...]) -> None:
        """Close a set whose trees keep the budget together, put another among the open ones."""
        tolerance = weighted_sum(self.weights, (solution.tolerance for solution in solutions))
        self.tolerance = max(self.tolerance, tolerance)
        trees = [solution.tree for solution in solutions if solution.tree is not None]
        bound = weighted_sum(self.weights, (solution.bound for solution in solutions))
        self._offer(trees)
        if self._is_affordable(sensors_of(self.problems, trees)):
            self.closed = min(self.closed, bound)
            return
        self._offer(self._repaired(solutions, held))
        self.n_created += 1
        heapq.heappush(self.open, _Set(bound, self.n_created, held, banned, solutions))
