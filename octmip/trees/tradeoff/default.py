"""The default answer: the tree that holds on new rows as far as cross-validation tells, where no depth is named."""

import contextlib
import time
from dataclasses import dataclass, replace

from octmip.trees.methods.options import NO_OPTIONS
from octmip.trees.problem import Problem
from octmip.trees.run import Run
from octmip.trees.solution import Limits, Solution, Stop
from octmip.trees.solver import solve_run
from octmip.trees.tradeoff.choice import Choice, choose_default

FEW_ROWS_DEPTH = 1
"""Where rows are too few to choose by, one split at most."""
INTERRUPTED_DEPTH = 3
"""Of CART's tree, which is all that there is when a signal ends the cross-validation before its second fold."""


@dataclass(frozen=True, slots=True, eq=False)
class DefaultAnswer:
    """A tree without a depth that was asked for.

    Attributes
    ----------
    problem
        with the depth and the leaf penalty that were chosen.
    solution
        of it; `details["choice"]` says in JSON how it was chosen and what it costs on new rows, or why it was not.
    choice
        everything that it was chosen from; None where nothing was.
    """

    problem: Problem
    solution: Solution
    choice: Choice | None


def solve_default(problem: Problem, run: Run) -> DefaultAnswer:
    """Return the tree that `choose_default` chooses, within the seconds of the run's limits and by so many threads.

    Of the run, method, progress and other limits have no effect. Ctrl-C leaves the choice among what is finished, or
    CART's tree before there is anything to choose by.

    Parameters
    ----------
    problem
        its depth and leaf penalty have no effect.

    Raises
    ------
    ProblemError, SolverError
        as `choose_tree`.
    """
    from joblib import parallel_config  # only here: every command would wait for it

    start = time.perf_counter()
    with contextlib.ExitStack() as stack:
        if run.options.cluster is None:
            stack.enter_context(parallel_config(backend="threading", n_jobs=run.n_jobs))
        try:
            choice = choose_default(problem, seconds=run.limits.seconds, seed=run.seed, options=run.options)
        except KeyboardInterrupt:
            return _unchosen(problem, INTERRUPTED_DEPTH, replace(run, method="cart"), "interrupted")
    if choice is None:
        return _unchosen(problem, FEW_ROWS_DEPTH, replace(run, method="auto"), "too few rows to cross-validate")
    whole = replace(problem, depth=choice.problem.depth, leaf_penalty=choice.problem.leaf_penalty)
    objective = whole.objective(choice.tree)  # in truth that of the merged samples; sums of float64 differ by rounding
    bound = min(choice.solution.bound, objective)
    seconds = time.perf_counter() - start
    return DefaultAnswer(whole, replace(choice.solution, objective=objective, bound=bound, seconds=seconds), choice)


def _unchosen(problem: Problem, depth: int, run: Run, reason: str) -> DefaultAnswer:
    shallow = replace(problem, depth=depth, leaf_penalty=0.0)
    solution = solve_run(shallow, replace(run, options=NO_OPTIONS, limits=Limits(seconds=run.limits.seconds)))
    stop = Stop.INTERRUPTED if reason == "interrupted" else solution.stop
    return DefaultAnswer(shallow, replace(solution, stop=stop, details={"choice": {"reason": reason}}), None)
