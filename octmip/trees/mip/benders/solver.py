"""Benders: OCT's optimum by HiGHS alone, through a master over the cuts of a node and the trees below as subproblems.

The bound of a run that is stopped is that of the master: no tree is cheaper than its cheapest cut.
"""

import math
import time
from concurrent.futures import ThreadPoolExecutor
from functools import partial

import numpy as np

from octmip.trees.answer.solution import Limits, Progress, ProgressCallback, Solution, Stop, relative_gap
from octmip.trees.methods.options import BendersOptions
from octmip.trees.mip.benders.memory import Memory
from octmip.trees.mip.benders.node import NodeSearch, Tasks
from octmip.trees.mip.benders.run import Runner
from octmip.trees.mip.benders.subproblem import Subproblem
from octmip.trees.mip.blocks import axis
from octmip.trees.mip.columns import over_columns
from octmip.trees.mip.engine import Clock, LimitReachedError
from octmip.trees.mip.highs import process
from octmip.trees.mip.incumbent import canonicalise, starting_tree
from octmip.trees.mip.prices import whole_prices
from octmip.trees.mip.result import Known, RunResult, solution_of
from octmip.trees.mip.rows import Rows
from octmip.trees.nodes.tree import Node
from octmip.trees.question.problem import Problem

METHOD = "benders"


@over_columns
def solve_benders(
    problem: Problem,
    *,
    limits: Limits = Limits(),  # noqa: B008  (frozen)
    incumbent: Node | None = None,
    seed: int = 0,
    n_jobs: int = 1,
    progress: ProgressCallback | None = None,
    options: BendersOptions = BendersOptions(),  # noqa: B008 (frozen)
) -> Solution:
    """Solve OCT by logic-based Benders decomposition on HiGHS and return the tree and the bound.

    Parameters
    ----------
    incumbent
        tree to start from; None: CART's.
    n_jobs
        subproblems that run side by side, four at most; the tree is the same for any number.
    options
        read by `octmip.trees.solver`: which tree to start from.

    Raises
    ------
    ProblemError
        the problem asks for hyperplanes, or the incumbent is deeper than it allows.
    SolverError
        HiGHS cannot be run, or refuses a model.
    """
    axis.require_axis(problem, METHOD)
    clock = Clock(limits, time.perf_counter())
    if problem.shape.sensor_budget is not None:  # masters are linear programs, solved here; joint sides are not
        process.warm()
    tree = starting_tree(problem, incumbent, seed)
    prices = whole_prices(problem, problem.objective(tree))
    known = Known(tree, problem.objective(tree), prices, Rows())
    result = RunResult(known, tree, Stop.TIME, {"start": {"objective": known.objective, "accepted": True}})
    runner = Runner(clock, seed, lambda: None)
    try:
        clock.check()
        whole = Subproblem(problem, prices, np.arange(problem.samples.n_samples))
        _run(problem, whole, runner, result, n_jobs, progress)
    except LimitReachedError as reached:
        result.stop = reached.stop
    except KeyboardInterrupt:
        result.stop = Stop.INTERRUPTED
    result.n_nodes = runner.n_subproblems
    result.details["subproblems"] = runner.n_subproblems
    return solution_of(problem, result, method=METHOD, seed=seed, seconds=clock.seconds, gap=limits.gap)


def _run(
    problem: Problem,
    subproblem: Subproblem,
    runner: Runner,
    result: RunResult,
    n_jobs: int,
    progress: ProgressCallback | None,
) -> None:
    """Search at the root, keeping tree, bound and reason in `result` as they are found."""
    prices = subproblem.prices
    memory = Memory(prices.weights * prices.costs[prices.profile].max(axis=1))
    if problem.shape.depth == 1:
        answer = runner.answer(subproblem, memory)
        result.better(problem, canonicalise(problem, answer.tree))
        result.price_bound, result.stop = math.floor(answer.bound), Stop.OPTIMAL
        return
    root = NodeSearch.of(subproblem, result.tree, runner.answer, runner.together, memory)
    rounds = _RootRounds(problem, root, runner, result, progress)
    runner.report = rounds.report
    with ThreadPoolExecutor(max(1, n_jobs)) as pool:
        tasks: Tasks = runner.in_turn if n_jobs <= 1 else partial(runner.side_by_side, pool)
        try:
            root.run(tasks, rounds.after_round)
            result.stop = rounds.stop
        finally:
            rounds.after_round()


class _RootRounds:
    """Keeps the root's state in the result of the run, reports it, and says when a limit of gap or nodes is reached."""

    def __init__(
        self,
        problem: Problem,
        root: NodeSearch,
        runner: Runner,
        result: RunResult,
        progress: ProgressCallback | None,
    ) -> None:
        self.problem, self.root, self.runner, self.result, self.progress = problem, root, runner, result, progress
        self.stop = Stop.OPTIMAL

    def after_round(self) -> bool:
        """Keep the state; return whether the run is to end."""
        self.result.better(self.problem, canonicalise(self.problem, self.root.best))
        self.result.price_bound = math.floor(self.root.bound)
        limits = self.runner.clock.limits
        objective = self.problem.objective(self.result.tree)
        if 0 < limits.gap >= relative_gap(objective, self._bound()):
            self.stop = Stop.GAP
        elif self.runner.n_subproblems >= limits.nodes:
            self.stop = Stop.NODES
        return self.stop is not Stop.OPTIMAL

    def _bound(self) -> float:
        prices = self.result.known.prices
        return max(0.0, float(prices.lower_bound(self.result.price_bound)))

    def report(self) -> None:
        """Hand the state to the caller's progress."""
        self.runner.clock.check()
        if self.progress is not None:
            clock, objective = self.runner.clock, self.problem.objective(self.result.tree)
            bound = min(self._bound(), objective)
            self.progress(Progress(clock.seconds, objective, bound, self.runner.n_subproblems))
