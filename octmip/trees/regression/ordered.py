"""Regression trees in order: the best tree in no order, which often keeps the one asked for, then a search from it."""

import time
from dataclasses import replace

from octmip.trees.answer.solution import Progress, Solution, Stop, closing_tolerance
from octmip.trees.methods.pruning import fitting
from octmip.trees.nodes.tree import Node
from octmip.trees.question.problem import Problem
from octmip.trees.runs.registry import solvers_of
from octmip.trees.runs.solver_call import Call

FREE_SHARE = 0.5
"""Of the time that is left goes to the proof in no order."""


def freed(problem: Problem) -> Problem | None:
    """Return a problem of numbers in order without order and number of splits; None of others, or if none proves it."""
    if problem.loss.predicts == "class" or problem.shape.monotone is None:
        return None
    free = problem.replace(monotone=None, max_splits=None)
    return free if free.is_provable and solvers_of(free)["exact"].refusal(free) is None else None


def in_order(call: Call, free_problem: Problem, first: Solution | None) -> Solution:
    """Return the best tree in no order where that keeps the order, else the best that a search from it finds.

    No tree in order costs less than the best in no order, so its bound holds. The search starts from that tree put in
    order, or from the best tree in order that is less deep, whichever is better.
    """
    problem, run, start = call.problem, call.run, time.perf_counter()
    known: list[Node] = [problem.best_leaf()] if first is None or first.tree is None else [first.tree]

    def shown(state: Progress) -> None:  # the bound holds in order too, the tree need not
        if run.progress is not None:
            run.progress(replace(state, objective=min(map(problem.objective, known))))

    freed = replace(call, problem=free_problem, run=replace(run, progress=shown, limits=replace(run.limits, gap=0.0)))
    free = freed.solve("exact", None, share=FREE_SHARE)
    put = fitting(problem, free)
    known.append(put.tree)
    tolerance = closing_tolerance(put.objective, free.bound, problem.least_saving_from(put.objective))
    if free.stop is Stop.OPTIMAL and tolerance >= 0:
        return replace(put, stop=free.stop, tolerance=tolerance)
    if free.stop is Stop.INTERRUPTED:
        return put
    if problem.shape.depth > 1:
        depth = problem.shape.depth - 1
        less = replace(call, problem=problem.replace(depth=depth), run=replace(run, progress=None))
        known.append(in_order(less, free_problem.replace(depth=depth), None).tree or problem.best_leaf())

    def searched(state: Progress) -> None:
        if run.progress is not None:
            run.progress(replace(state, bound=free.bound, n_nodes=state.n_nodes + free.n_nodes))

    best = min(known, key=problem.objective)
    found = replace(call, run=replace(run, progress=searched)).solve("search", best, options=run.options)
    n_nodes = found.n_nodes + free.n_nodes
    return replace(found, bound=min(free.bound, found.objective), n_nodes=n_nodes, seconds=time.perf_counter() - start)
