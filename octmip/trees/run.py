"""Run: how a problem is solved, apart from the problem, handed on as one by functions that solve several alike."""

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Literal

import numpy as np

from octmip.trees.methods import interruption
from octmip.trees.methods.options import NO_OPTIONS, Options, refuse_untyped
from octmip.trees.problem import Problem
from octmip.trees.solution import Limits, ProgressCallback, Solution, Stop
from octmip.trees.tree import Node

Method = Literal["auto", "search", "exact", "oct", "oct_h", "flow", "benders", "cart"]


@dataclass(frozen=True, slots=True)
class Run:
    """Method, limits, seed, threads, options and progress of a solve; see `octmip.solve`.

    Attributes
    ----------
    method
        name of the solver, or "auto".
    limits
        of each solve.
    seed
        of all random choices.
    n_jobs
        threads.
    options
        of the method's own solver.
    progress
        called now and then with the state of the solver.

    Raises
    ------
    ProblemError
        the options are of none of their classes.
    """

    method: Method = "auto"
    limits: Limits = field(default_factory=Limits)
    seed: int = 0
    n_jobs: int = 1
    options: Options = NO_OPTIONS
    progress: ProgressCallback | None = None

    def __post_init__(self) -> None:
        refuse_untyped(self.options, self.method)


def until_interrupted(problem: Problem, solve: Callable[[], Solution], name: str, known: Node | None) -> Solution:
    """Return the solution of `solve`; once the call is interrupted, the tree that is known, or the best single leaf.

    Parameters
    ----------
    problem
        that is solved.
    solve
        does so; where the call was interrupted before, it is not called.
    name
        of the solver.
    known
        a tree of the problem.
    """
    with interruption.whole_call():
        if not interruption.is_heard():
            try:
                solution = solve()
            except KeyboardInterrupt:
                interruption.note()
            else:
                if solution.stop is Stop.INTERRUPTED:
                    interruption.note()
                return solution
        tree = problem.best_leaf() if known is None else known
        return Solution(tree, problem.objective(tree), -np.inf, Stop.INTERRUPTED, 0.0, 0, name, "1", 0)
