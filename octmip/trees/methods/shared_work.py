"""Cuts of an exact search and turns of a local one, done by the workers of a cluster: what is sent, and what they do.

A worker makes the native core's problem once and keeps it; a task is one cut of the root with the bounds of both sides
and the cost that it must stay below, or one turn of one restart. Its result depends on nothing else, so that a task may
run anywhere, and again.
"""

import hashlib
import pickle
import time
from collections import OrderedDict
from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple

from octmip.errors import SolverError
from octmip.trees import _native
from octmip.trees.answer.solution import Limits
from octmip.trees.encoding import NodeRow
from octmip.trees.methods.cluster import Cluster, Future, is_given_up

MOST_KEPT = 2
"""Problems that a worker keeps."""
_kept: "OrderedDict[str, Any]" = OrderedDict()


class SharedProblem(NamedTuple):
    """A problem of the native core as it is sent.

    Attributes
    ----------
    digest
        sha256 of the content, under which a worker keeps it.
    content
        pickled: arguments of `_native.Problem`, those of the solver beside it, version of the native core that asks
        (another one may number cuts otherwise). Bytes, as arrays that arrive by themselves may not be aligned.
    """

    digest: str
    content: bytes


def shared_problem(arguments: Mapping[str, Any], *options: Any) -> SharedProblem:
    """Return a problem to be sent to workers, with what their solver takes beside it."""
    content = pickle.dumps((arguments, options, _native.__version__))
    return SharedProblem(hashlib.sha256(content).hexdigest(), content)


def submitter(
    cluster: Cluster, arguments: Mapping[str, Any], off: Sequence[str], *, is_logged: bool
) -> Callable[[int, Any], Future]:
    """Return what submits a cut of a problem: called by the native core with the level and the cut.

    With `is_logged` the answer holds the cut's lines of a proof log.
    """
    shared = cluster.share(shared_problem(arguments, sorted(off), is_logged))
    return lambda level, cut: cluster.submit(solve_cut, shared, level, cut)


def turn_submitter(
    cluster: Cluster, arguments: Mapping[str, Any], incumbent: list[NodeRow] | None, seed: int, effort: tuple[int, int]
) -> Callable[[Any, Any], Future]:
    """Return what submits a turn of a restart: called by the native core with the turn and the limits that are left.

    `effort` is the numbers of restarts and of perturbations.
    """
    shared = cluster.share(shared_problem(arguments, incumbent, seed, *effort))
    return lambda turn, limits: cluster.submit(take_turn, shared, turn, limits)


def solve_cut(problem: SharedProblem, level: int, cut: Any) -> Any:
    """Solve a cut; done by a worker."""
    solved = _solver(problem, _native.CutSolver).solve(level, cut)
    if solved is None:
        raise KeyboardInterrupt
    return solved


def take_turn(problem: SharedProblem, turn: Any, limits: Mapping[str, float]) -> Any:
    """Take a turn of a restart; done by a worker, which stops when nobody waits for it any more.

    The seconds count from here: a worker begins with the next task when it is free.
    """
    started = time.perf_counter()
    solver = _solver(problem, _native.TurnSolver)
    is_whole = False
    try:
        seconds = max(0.0, limits["seconds"] - (time.perf_counter() - started))
        taken = solver.take(turn, Limits(**{**limits, "seconds": seconds}), _stop_when_given_up)
        is_whole = taken["is_whole"]
        return taken
    finally:
        if not is_whole:  # what the solver has made of the problem may have been cut short, too
            _kept.pop(problem.digest, None)


def _stop_when_given_up(*_state: float) -> None:
    if is_given_up():
        raise SolverError("a turn was given up: nobody waits for it any more")


def _solver(problem: SharedProblem, kind: Callable[..., Any]) -> Any:
    """Return the solver of a problem, made or kept; the one asked for last is kept longest."""
    solver = _kept.pop(problem.digest, None) or _made(problem.content, kind)
    _kept[problem.digest] = solver
    while len(_kept) > MOST_KEPT:
        _kept.popitem(last=False)
    return solver


def _made(content: bytes, kind: Callable[..., Any]) -> Any:
    arguments, options, version = pickle.loads(content)  # from the scheduler, which runs what it is sent anyhow
    if version != _native.__version__:
        raise SolverError(
            f"a worker has octmip {_native.__version__}; expected {version}, as the process that asks; install the same"
        )
    return kind(_native.Problem(**arguments), *options)
