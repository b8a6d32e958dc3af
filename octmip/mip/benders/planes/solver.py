"""Benders for hyperplanes of few features, depth 1 and 2: the best tree, and the bound over the mu-separated ones."""

import math
import time
from dataclasses import dataclass

from octmip.mip.benders.planes.question import Question
from octmip.mip.benders.planes.search import PlaneSearch
from octmip.mip.engine import Clock, LimitReachedError
from octmip.mip.highs import process
from octmip.mip.incumbent import canonicalise, starting_tree
from octmip.mip.prices import whole_prices
from octmip.mip.result import Known, RunResult, solution_of
from octmip.mip.rows import Rows
from octmip.problem import Problem
from octmip.solution import Limits, Progress, ProgressCallback, Solution, Stop, relative_gap
from octmip.tree import Node

METHOD = "benders"


def solve_planes(
    problem: Problem,
    *,
    limits: Limits = Limits(),  # noqa: B008  (frozen)
    incumbent: Node | None = None,
    seed: int = 0,
    progress: ProgressCallback | None = None,
    mu: float | None = None,
) -> Solution:
    """Solve OCT-H of few features by combinatorial Benders cuts on HiGHS and return the tree and the bound.

    Parameters
    ----------
    incumbent
        tree to start from; None: CART's.
    mu
        strictness; None: chosen from the data by the rule of `octmip.mip.blocks.hyperplanes`.

    Raises
    ------
    ProblemError
        the problem has what the cuts do not speak about (`octmip.mip.benders.planes.question`).
    SolverError
        HiGHS cannot be run, or refuses a model.
    """
    clock = Clock(limits, time.perf_counter())
    tree = starting_tree(problem, incumbent, seed)
    prices = whole_prices(problem, problem.objective(tree))
    question = Question.of(problem, prices, tree, mu)
    process.warm()
    result = RunResult(Known(tree, problem.objective(tree), prices, Rows()), tree, Stop.TIME, {})
    planes = PlaneSearch(question, clock, seed, lambda: None)
    run = _Run(problem, question, clock, result, progress, planes)
    planes.report = run.report
    try:
        run.search()
    except LimitReachedError as reached:
        result.stop = reached.stop
    except KeyboardInterrupt:
        result.stop = Stop.INTERRUPTED
    run.keep()
    return solution_of(
        problem, result, method=METHOD, seed=seed, seconds=clock.seconds, given_bound=-math.inf, gap=limits.gap
    )


@dataclass(slots=True, eq=False)
class _Run:
    """One run: asks for cheaper trees until bound and best tree meet, and keeps both in the result."""

    problem: Problem
    question: Question
    clock: Clock
    result: RunResult
    progress: ProgressCallback | None
    planes: PlaneSearch

    def search(self) -> None:
        """Raise the bound and lower the best price, by halves of what lies between."""
        prices, limits = self.result.known.prices, self.clock.limits
        planes = self.planes
        best = int(prices.of_tree(self.problem, self.result.tree))
        while self._bound < best:
            target = self._bound + max(1, (best - self._bound) // 2)
            found = planes.cheaper(target)
            if found is not None:
                best = self._take(found, target)
            self.keep()
            if 0 < limits.gap >= relative_gap(self.problem.objective(self.result.tree), self._shown_bound):
                self.result.stop = Stop.GAP
                return
            if self.result.refuted:
                return
        self.result.stop = Stop.OPTIMAL

    @property
    def _bound(self) -> int:
        best = int(self.result.known.prices.of_tree(self.problem, self.result.tree))
        return int(min(self.planes.bound, best))

    @property
    def _shown_bound(self) -> float:
        return max(0.0, float(self.result.known.prices.lower_bound(self._bound)))

    def _take(self, found: Node, target: int) -> int:
        """Take a tree that HiGHS holds to be cheaper than the target, and return the best price."""
        prices = self.result.known.prices
        tree = canonicalise(self.problem, found)
        price = int(prices.of_tree(self.problem, tree))
        if price >= target:
            self.result.refuted = f"HiGHS claims a tree below {target} but it costs {price} when all samples are routed"
        self.result.better(self.problem, tree)
        return int(prices.of_tree(self.problem, self.result.tree))

    def keep(self) -> None:
        """Keep bound and figures in the result."""
        self.result.price_bound = self._bound
        question, details = self.question, self.result.details
        details["scope"] = question.space.scope(question.mu)
        details["mu"] = question.mu
        self.result.n_nodes = self.planes.n_masters
        details["cuts"] = {"cores": len(self.planes.cores), "separations": self.planes.separation.n_models}

    def report(self) -> None:
        """Hand the state to the caller's progress."""
        if self.progress is not None:
            objective, bound = self.problem.objective(self.result.tree), self._shown_bound
            self.progress(Progress(self.clock.seconds, objective, min(bound, objective), self.planes.n_masters))
