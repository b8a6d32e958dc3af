"""Tables so large that to set up a search of all rows takes more than the time limit: the tree of drawn rows.

Ranks, the order of each column and a copy of the table look at no clock. How long they take follows from the number of
readings. Where a proof and the search behind it would be late for that reason alone, rows are drawn at random, and the
leaves of their tree are fitted to all rows.
"""

import math
from dataclasses import replace

import numpy as np

from octmip.trees.answer.solution import Solution, Stop
from octmip.trees.methods.options import ExactOptions, Options
from octmip.trees.methods.ordering import ordered
from octmip.trees.question.problem import Problem
from octmip.trees.runs.registry import solvers_of
from octmip.trees.runs.solver_call import Call

SETUP_READINGS = {"class": 5e6, "number": 1e6}
"""So many readings (samples times features) are ranked and laid out in a second, at the least, by what is predicted."""
LARGE = 1e6
"""Readings from which on that time counts."""
SETUP_SHARE = 0.25
"""Of the time that is left, in which the drawn rows are set up."""
SECONDS_OF_ROW = {"class": 5e-7, "number": 1.2e-6}
"""To fit the leaves of a tree of drawn rows to all rows, and to check it; errors of numbers are summed exactly."""
SECONDS_OF_COST = 1e-7
"""To set up the cost of one class told for another, which no step of a search interrupts."""


def search_seconds(problem: Problem, left: float) -> float:
    """Return the seconds of those that are left in which a tree may be searched: its leaves take the rest."""
    kind = problem.loss.predicts
    after = problem.samples.n_samples * SECONDS_OF_ROW[kind]
    if kind == "class":
        after += problem.samples.n_classes**2 * SECONDS_OF_COST
    return left - min(left / 2, after)


def setup_seconds(problem: Problem, name: str, options: Options) -> float:
    """Return the seconds in which the core sets up a large table for the exact proof, or for the search; else 0.

    0 where the proof has to be tried: nothing else knows what is asked for, or it writes a file.
    """
    is_asked = isinstance(options, ExactOptions) and not (options.proof is None and options.checkpoint is None)
    can_search = solvers_of(problem)["search"].refusal(problem) is None
    is_small = problem.samples.features.size < LARGE
    if name != "exact" or problem.shape.split != "axis" or is_asked or not can_search or is_small:
        return 0.0
    return problem.samples.features.size / SETUP_READINGS[problem.loss.predicts]


def tree_of_drawn_rows(call: Call) -> Solution:
    """Return the tree of a search over as many rows, drawn at random, as the time that is left suffices for.

    Its leaves are the best for all rows; those of a size have no fewer samples among all. There is no bound.
    `details["n_rows"]` is the number of rows drawn.
    """
    problem, left = call.problem, call.run.limits.remaining(call.start).seconds
    seconds = search_seconds(problem, left)
    n_drawn = max(1, int(SETUP_SHARE * seconds * SETUP_READINGS[problem.loss.predicts] / problem.samples.n_features))
    rows = np.sort(np.random.default_rng(call.run.seed).permutation(problem.samples.n_samples)[:n_drawn])
    share = seconds / left if left else 0.0
    found = replace(call, problem=problem.of_rows(rows)).solve("search", None, share=share)
    tree = problem.with_sides(ordered(problem, problem.with_best_leaves(found.tree)))
    stop = Stop.TIME if found.stop is not Stop.INTERRUPTED else found.stop
    details = {**found.details, "n_rows": len(rows), "tree_by": "search"}
    return replace(found, tree=tree, objective=problem.objective(tree), bound=-math.inf, stop=stop, details=details)
