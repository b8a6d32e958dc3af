"""The default answer: the tree that holds on new rows as far as cross-validation tells, where no depth is named."""

import contextlib
import math
import time
from collections.abc import Callable
from dataclasses import dataclass, replace

from octmip.trees.answer.solution import Limits, Solution, Stop
from octmip.trees.methods.options import NO_OPTIONS
from octmip.trees.methods.ordering import ordered
from octmip.trees.question.problem import Problem
from octmip.trees.runs.drawn_rows import search_seconds
from octmip.trees.runs.registry import Run
from octmip.trees.solver import solve_run
from octmip.trees.tradeoff.choice import N_FOLDS, SHARE_OF_PATHS, Choice, choose_default
from octmip.trees.tradeoff.sample import sampled

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


def solve_default(problem: Problem, run: Run, stage: Callable[[str], None] | None = None) -> DefaultAnswer:
    """Return the tree that `choose_default` chooses, within the seconds of the run's limits and by so many threads.

    Where they do not suffice for a tree of all rows, it is chosen and grown on rows that are drawn at random.
    `details["choice"]["n_rows"]` is their number. Leaves, objective and certificate are those of all rows.

    Of the run, method, progress and other limits have no effect. Ctrl-C leaves the choice among what is finished, or
    CART's tree before there is anything to choose by.

    Parameters
    ----------
    problem
        its depth and leaf penalty have no effect.
    stage
        called with the share that is done, in words.

    Raises
    ------
    ProblemError, SolverError
        as `choose_tree`.
    """
    # Only here: every command would wait for them. Before the clock starts, as in `solve_run`.
    import sklearn.tree  # noqa: F401
    from joblib import parallel_config

    start = time.perf_counter()
    # One tree for all rows and one for each fold, so many at a time.
    turns = math.ceil((N_FOLDS + 1) / run.n_jobs) if run.options.cluster is None else 1
    part = sampled(problem, SHARE_OF_PATHS * run.limits.seconds, turns, run.seed)
    with contextlib.ExitStack() as stack:
        if run.options.cluster is None:
            stack.enter_context(parallel_config(backend="threading", n_jobs=run.n_jobs))
        try:
            left = max(0.0, run.limits.seconds - (time.perf_counter() - start))
            if part is not None:
                left = search_seconds(problem, left)
            choice = choose_default(part or problem, seconds=left, seed=run.seed, options=run.options, stage=stage)
        except KeyboardInterrupt:
            return _unchosen(problem, INTERRUPTED_DEPTH, replace(run, method="cart"), "interrupted")
    if choice is None:
        return _unchosen(problem, FEW_ROWS_DEPTH, replace(run, method="auto"), "too few rows to cross-validate")
    whole = problem.replace(depth=choice.problem.shape.depth, leaf_penalty=choice.problem.shape.leaf_penalty)
    found = choice.solution if part is None else _on_all_rows(whole, choice, part.samples.n_samples)
    objective = whole.objective(found.tree)  # in truth that of the merged samples; sums of float64 differ by rounding
    bound = min(found.bound, objective)
    seconds = time.perf_counter() - start
    return DefaultAnswer(whole, replace(found, objective=objective, bound=bound, seconds=seconds), choice)


def _on_all_rows(whole: Problem, choice: Choice, n_rows: int) -> Solution:
    """Return the tree that was chosen on some rows with the best leaves for all, and without their bound."""
    tree = whole.with_sides(ordered(whole, whole.with_best_leaves(choice.tree)))
    said = {**choice.solution.details, "choice": {**choice.to_json(), "n_rows": n_rows}}
    return replace(choice.solution, tree=tree, bound=-math.inf, stop=Stop.TIME, details=said)


def _unchosen(problem: Problem, depth: int, run: Run, reason: str) -> DefaultAnswer:
    shallow = problem.replace(depth=depth, leaf_penalty=0.0)
    solution = solve_run(shallow, replace(run, options=NO_OPTIONS, limits=Limits(seconds=run.limits.seconds)))
    stop = Stop.INTERRUPTED if reason == "interrupted" else solution.stop
    return DefaultAnswer(shallow, replace(solution, stop=stop, details={"choice": {"reason": reason}}), None)
