"""The optimum without some sensors, each search made once: what one has proven others need not."""

import time
from dataclasses import dataclass, replace
from fractions import Fraction

from octmip.trees.answer import interruption
from octmip.trees.answer.solution import Limits, ProgressCallback, Solution, Stop
from octmip.trees.near_sets.counting import near_optimal
from octmip.trees.nodes.tree import Node
from octmip.trees.question.problem import Problem
from octmip.trees.solver import solve, until_interrupted


@dataclass(frozen=True, slots=True)
class Without:
    """The optimum without some sensors.

    Attributes
    ----------
    sensors
        that are left out.
    objective
        of the best tree found without them.
    bound
        proven for every tree without them; equal to the objective where that is proven.
    tree
        the best tree found.
    read
        sensors that it reads.
    cost
        the objective, none of its digits lost.
    least
        no tree without them costs less, in exact arithmetic.
    """

    sensors: tuple[str, ...]
    objective: float
    bound: float
    tree: Node
    read: tuple[str, ...]
    cost: Fraction
    least: Fraction

    @property
    def is_proven(self) -> bool:
        """Whether no tree without them is better."""
        return self.bound >= self.objective


def loss_of(problem: Problem, sensors: tuple[str, ...], solution: Solution) -> Without:
    """Return what a solution says of the trees without some sensors."""
    bound = solution.objective if solution.meets_bound else solution.bound
    cost = problem.exact_objective(solution.tree)
    least = min(cost, Fraction(max(solution.bound, 0.0)))
    return Without(
        sensors, solution.objective, bound, solution.tree, problem.shape.sensors_used(solution.tree), cost, least
    )


class Calls:
    """Searches of one problem without some sensors; what one has proven others need not."""

    def __init__(
        self,
        problem: Problem,
        limits: Limits,
        seed: int,
        n_jobs: int,
        progress: ProgressCallback | None,
        started: float,
    ) -> None:
        self.problem, self.limits, self.seed, self.n_jobs = problem, limits, seed, n_jobs
        self.progress, self.started = progress, started
        self.known: list[Without] = []
        self.stop = Stop.NUMERICS

    @property
    def remaining(self) -> Limits:
        """The limits of a search that begins now: no time after a signal."""
        spent = time.perf_counter() - self.started
        return replace(self.limits, seconds=0.0 if interruption.is_heard() else max(0.0, self.limits.seconds - spent))

    def solve(self, problem: Problem, incumbent: Node | None) -> Solution:
        """Return the solution of one exact search; after a signal the best leaf at once."""
        arguments = self.remaining, incumbent, self.seed, self.n_jobs, self.progress
        found = until_interrupted(problem, lambda: solve(problem, "exact", *arguments), "exact", incumbent)
        if not found.meets_bound:
            self.stop = found.stop
        return found

    def without(self, sensors: tuple[str, ...]) -> Without:
        """Return the optimum without some sensors: known where the best tree without fewer of them reads none."""
        for known in self.known:
            if set(known.sensors) <= set(sensors) and not set(known.read) & set(sensors):
                return replace(known, sensors=sensors)
        found = loss_of(self.problem, sensors, self.solve(self._narrower(sensors), None))
        # No tree of a narrower problem is better than one of a wider: bounds go on.
        wider = [known for known in self.known if set(known.sensors) <= set(sensors)]
        bound = min(found.objective, max(found.bound, *(known.bound for known in wider)))
        found = replace(found, bound=bound, least=min(found.cost, max(found.least, *(known.least for known in wider))))
        self.known.append(found)
        return found

    def _narrower(self, sensors: tuple[str, ...]) -> Problem:
        """Return the problem without some sensors."""
        left = [f for f, name in enumerate(self.problem.shape.sensor_of_feature or ()) if name not in sensors]
        left = [f for f in left if self.problem.shape.is_allowed((f,))]
        if left:
            return self.problem.replace(allowed_splits=[[f] for f in left])
        return self.problem.replace(leaf_size=self.problem.samples.n_samples)  # no split is left: a leaf

    def compared(self, loss: Without, limit: Fraction) -> Without:
        """Return a loss whose optimum lies within the limit or beyond for certain, where its proof is whole."""
        if not (loss.is_proven and loss.least <= limit < loss.cost):
            return loss
        counted = near_optimal(
            self._narrower(loss.sensors),
            within=0,
            limits=self.remaining,
            most_predictions=0,
            incumbent=loss.tree,
            n_jobs=self.n_jobs,
        )
        if counted.optimum is None:
            self.stop = counted.stop
            return loss
        (best,) = counted.best(1)
        read, paid, cost = self.problem.shape.sensors_used(best.tree), best.objective, counted.optimum
        return Without(loss.sensors, paid, paid, best.tree, read, cost, cost)
