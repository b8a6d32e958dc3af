"""Local search: good trees of any depth and either kind of split, without a proof; a thin wrapper of the native core.

    minimise  the objective of the Problem
    by        restarts from greedy trees; at one node after the other, in random order, the best new split with the rest
              of the tree fixed, a leaf in its place, or one of its children in its place; exact subtrees of up to
              three levels at the bottom; perturbations of local optima, kept when they are no worse
    planes    lines of hyperplanes, each swept exactly; logistic fits to the sides that the samples prefer; all planes
              of a subtree moved together as a soft tree; see docs/theory/search.md

Every restart draws from its own random stream, given by the seed and the restart's number, so one seed gives one tree
for any number of threads unless time runs out. The first restart begins at the greedy tree, not randomised, looks ahead
with exact subtrees, and is what a hyperplane tree starts from too, so that it is never worse than the axis-aligned one.
What is searched is the problem of `merging.py`, so rows repeated and rows weighed give one tree, whatever their order.
Source: Bertsimas & Dunn (2019), Machine Learning Under a Modern Optimization Lens, ch. 8, for the moves at one node.
"""

import math
import time
from collections.abc import Callable

from octmip.trees import _native
from octmip.trees.answer.solution import Limits, ProgressCallback, Solution, Stop
from octmip.trees.encoding import integer_costs, native_arguments, rows_from_tree, tree_from_rows
from octmip.trees.methods.cluster import Cluster
from octmip.trees.methods.merging import merged
from octmip.trees.methods.native_call import (
    better,
    check_threads,
    feasible_incumbent,
    native_progress,
    relabelled,
)
from octmip.trees.methods.options import SearchOptions
from octmip.trees.methods.polish import polished
from octmip.trees.methods.shared_work import turn_submitter
from octmip.trees.nodes.reached import centred, without_empty_sides
from octmip.trees.nodes.tree import Node, simplify
from octmip.trees.question.problem import Problem

# Restarts, and perturbations in a row without a better tree that end one: hyperplanes profit from longer restarts, and
# small axis-aligned problems from both more and longer ones, for which there is time.
EFFORT = {"axis": (9, 16), "hyperplane": (6, 60)}
MOST_EFFORT = (36, 48)
SMALL = (300_000, 200_000)  # samples x features x restarts, and x perturbations, up to which there are more
GRACE = 0.3
"""Seconds beyond the limit within which planes are still polished."""


def local_search(
    problem: Problem,
    *,
    limits: Limits = Limits(),  # noqa: B008 (frozen)
    incumbent: Node | Solution | None = None,
    seed: int = 0,
    n_jobs: int = 1,
    progress: ProgressCallback | None = None,
    options: SearchOptions = SearchOptions(),  # noqa: B008 (frozen)
) -> Solution:
    """Return the best tree that a local search finds.

    Parameters
    ----------
    problem
        the problem.
    limits
        wall seconds and nodes (visits to a node of the tree); a proof's limits do not apply.
    incumbent
        a tree of this problem; the first restart begins there, so the result is never worse.
    seed
        of the restarts' random streams.
    n_jobs
        threads.
    progress
        called every few hundredths of a second.
    options
        restarts and perturbations are by default those of `EFFORT`, more for a small axis-aligned problem. Of
        the perturbations in a row that end a restart, a quarter are made before the better restarts are chosen with
        hyperplanes, none without, and twice as many by the last. With `restarts=1, perturbations=0` the answer is
        quick: one descent and exact blocks of two levels. ``cluster`` is an open `Cluster` here, whose processes
        take the restarts' turns; Ctrl-C returns the best of the turns that are finished.

    Returns
    -------
    The solution; its bound is -inf, or the objective where no cost at all is left (`Stop.OPTIMAL`).

    Raises
    ------
    ProblemError
        `n_jobs` is below 1, or the incumbent is no tree of this problem.
    """
    check_threads(n_jobs)
    start, known = time.perf_counter(), feasible_incumbent(problem, incumbent)
    searched, ranks = merged(problem)
    effort, costs = _effort(searched), integer_costs(searched)
    first = None if known is None else rows_from_tree(without_empty_sides(known, searched.samples.features), ranks)
    n_restarts = effort[0] if options.restarts is None else int(options.restarts)
    n_perturbations = effort[1] if options.perturbations is None else int(options.perturbations)
    shared: Cluster | None = options.cluster
    arguments = native_arguments(searched, ranks, costs)
    turn = first, seed % 2**64, (n_restarts, n_perturbations)
    result = _native.search(
        _native.Problem(**arguments),
        first,
        # What was spent on ranks counts, too.
        limits.remaining(start),
        n_jobs,
        seed % 2**64,
        native_progress(progress, costs.value),
        n_restarts=n_restarts,
        n_perturbations=n_perturbations,
        submit=None if shared is None else (turn_submitter(shared, arguments, *turn), shared.n_threads),
    )
    latest = start + limits.seconds + GRACE
    tree = _finished(searched, tree_from_rows(result.rows, ranks), lambda: time.perf_counter() < latest)
    tree, objective = better(problem, problem.with_sides(tree), known)
    return Solution(
        tree=tree,
        objective=objective,
        bound=0.0 if objective == 0 else -math.inf,
        stop=_stop(result.stop, objective),
        seconds=time.perf_counter() - start,
        n_nodes=result.n_nodes,
        solver="search",
        version=_native.__version__,
        seed=seed,
    )


def _effort(problem: Problem) -> tuple[int, int]:
    """Return restarts and perturbations where the caller names none."""
    least = EFFORT[problem.shape.split]
    if problem.shape.split != "axis":
        return least
    restarts, perturbations = (
        max(few, min(many, small // problem.samples.features.size))
        for few, many, small in zip(least, MOST_EFFORT, SMALL, strict=True)
    )
    return restarts, perturbations


def _stop(name: str, objective: float) -> Stop:
    """Return the stop as a Solution means it: the core calls a tree optimal when its rounded costs are 0."""
    stop = Stop(name)
    if objective == 0 and stop is not Stop.INTERRUPTED:
        return Stop.OPTIMAL
    return Stop.FINISHED if stop is Stop.OPTIMAL else stop


def _finished(problem: Problem, tree: Node, goes_on: Callable[[], bool]) -> Node:
    """Return the tree with leaves labelled by the true costs, no idle splits, thresholds in mid-gap, simple planes."""
    simple = simplify(relabelled(problem, tree))
    return polished(problem, centred(simple, problem.samples.features), goes_on)
