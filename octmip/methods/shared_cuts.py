"""Cuts of a root solved by the workers of a cluster: what is sent to them, and what they do.

A worker makes the native core's problem once and keeps it; a task is one cut of the root with the bounds of both sides
and the cost that it must stay below. Its result depends on nothing else, so that a task may run anywhere, and again.
"""

import hashlib
import pickle
from collections import OrderedDict
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

from octmip import _native
from octmip.cluster import Cluster, Future
from octmip.errors import SolverError

MOST_KEPT = 2
"""Problems that a worker keeps."""
_kept: "OrderedDict[str, _native.CutSolver]" = OrderedDict()


class SharedProblem(NamedTuple):
    """A problem of the native core as it is sent.

    Attributes
    ----------
    digest
        sha256 of the content, under which a worker keeps it.
    content
        pickled: arguments of `_native.Problem`, prunes that are switched off, version of the native core that asks
        (another one may number cuts otherwise). Bytes, as arrays that arrive by themselves may not be aligned.
    """

    digest: str
    content: bytes


def shared_problem(arguments: tuple[Any, ...], off: Sequence[str]) -> SharedProblem:
    """Return a problem to be sent to workers."""
    content = pickle.dumps((arguments, sorted(off), _native.__version__))
    return SharedProblem(hashlib.sha256(content).hexdigest(), content)


def submitter(
    cluster: Cluster, arguments: tuple[Any, ...], off: Sequence[str], *, is_logged: bool = False
) -> Callable[[int, Any], Future]:
    """Return what submits a cut of a problem: called by the native core with the level and the cut.

    With `is_logged` the answer holds the cut's lines of a proof log.
    """
    shared = cluster.share(shared_problem(arguments, off))
    return lambda level, cut: cluster.submit(solve_cut, shared, level, cut, is_logged)


def solve_cut(problem: SharedProblem, level: int, cut: Any, is_logged: bool = False) -> Any:
    """Solve a cut; done by a worker."""
    if problem.digest not in _kept:
        _kept[problem.digest] = _solver(problem.content)
        while len(_kept) > MOST_KEPT:
            _kept.popitem(last=False)
    _kept.move_to_end(problem.digest)
    solved = _kept[problem.digest].solve(level, cut, is_logged)
    if solved is None:
        raise KeyboardInterrupt
    return solved


def _solver(content: bytes) -> _native.CutSolver:
    arguments, off, version = pickle.loads(content)  # from the scheduler, which runs what it is sent anyhow
    if version != _native.__version__:
        raise SolverError(
            f"a worker has octmip {_native.__version__}; expected {version}, as the process that asks; install the same"
        )
    return _native.CutSolver(_native.Problem(*arguments), off)
