"""One run of the decomposition: subproblems on HiGHS, side by side where there are threads, within limits.

The last level is a master alone (`octmip.trees.mip.benders.stump`), what lies above a `NodeSearch`; where a sensor
budget joins the two sides of a cut, both are one model of the flow formulation (`octmip.trees.mip.flow`).
"""

import threading
from collections.abc import Callable, Iterable
from concurrent.futures import FIRST_COMPLETED, ThreadPoolExecutor, wait
from dataclasses import dataclass, field

import numpy as np

from octmip.trees.answer.solution import Stop
from octmip.trees.mip.benders.cuts import Cut
from octmip.trees.mip.benders.memory import Memory
from octmip.trees.mip.benders.node import Evaluated, NodeSearch
from octmip.trees.mip.benders.stump import best_stump
from octmip.trees.mip.benders.subproblem import Answer, Subproblem
from octmip.trees.mip.engine import Clock, LimitReachedError, Request, run_formulation
from octmip.trees.mip.flow import encode
from octmip.trees.mip.incumbent import starting_tree
from octmip.trees.mip.result import Known, RunResult
from octmip.trees.mip.rows import Rows
from octmip.trees.nodes.tree import Node

POLL = 0.05  # seconds between two looks at Ctrl-C and progress


@dataclass(slots=True, eq=False)
class Runner:
    """What the subproblems of a run share: clock, seed, threads, and whether the run is to end.

    Attributes
    ----------
    clock
        of the whole run.
    seed
        of HiGHS.
    report
        called in the main thread while subproblems run; may raise.
    n_subproblems
        solved so far.
    """

    clock: Clock
    seed: int
    report: Callable[[], None]
    n_subproblems: int = 0
    _lock: threading.Lock = field(default_factory=threading.Lock)
    _is_ending: threading.Event = field(default_factory=threading.Event)

    def answer(self, subproblem: Subproblem, memory: Memory) -> Answer:
        """Return the best tree of a side, or the proof that its target is reached."""
        self.clock.check()
        self._poll()
        if subproblem.problem.shape.depth == 1:
            with self._lock:
                self.n_subproblems += 1
            return best_stump(subproblem)
        first = starting_tree(subproblem.problem, None, self.seed)
        return NodeSearch.of(subproblem, first, self.answer, self.together, memory).run(self.in_turn)

    def together(self, subproblem: Subproblem, cut: Cut, first: Node) -> Answer:
        """Return the best of a tree that makes a cut and of all others that make it, both sides in one flow model."""
        problem, prices = subproblem.problem, subproblem.prices
        self.clock.check()
        known = Known(first, problem.objective(first), prices, Rows(limit_check=self.clock.check))
        cuts = {cut.feature: np.array([cut.rank])}
        formulation = encode(problem, first, prices=prices, rows=known.rows, root=cuts)
        result = RunResult(known, first, Stop.TIME, {})
        request = Request("benders", limits=self.clock.left, seed=self.seed, progress=lambda _: self._poll())
        run_formulation(problem, formulation, request, self.clock, result)
        with self._lock:
            self.n_subproblems += 1
        if result.stop not in (Stop.OPTIMAL, Stop.NUMERICS):
            raise LimitReachedError(result.stop)
        price = prices.of_tree(problem, result.tree)
        bound = 0.0 if result.refuted or result.price_bound > price else float(result.price_bound)
        return Answer(result.tree, price, bound)

    def _poll(self) -> None:
        if self._is_ending.is_set():
            raise LimitReachedError(Stop.INTERRUPTED)
        if threading.current_thread() is threading.main_thread():
            self.report()

    def in_turn(self, tasks: list[Callable[[], Evaluated]]) -> Iterable[Evaluated]:
        """Run tasks one after another."""
        return (task() for task in tasks)

    def side_by_side(self, pool: ThreadPoolExecutor, tasks: list[Callable[[], Evaluated]]) -> list[Evaluated]:
        """Run tasks in the threads of a pool; an error, a limit or Ctrl-C ends them all."""
        running = [pool.submit(task) for task in tasks]
        try:
            left = set(running)
            while left:
                done, left = wait(left, timeout=POLL, return_when=FIRST_COMPLETED)
                for future in done:
                    future.result()
                self.report()
        except BaseException:
            self._is_ending.set()
            wait(running)
            raise
        return [future.result() for future in running]
