"""Calls of the native core: what exact, two_feature and search share on the way there and back.

incumbent (checked), progress in the problem's units  ->  native core
native core  ->  leaves labelled by the true costs, a proof log written whole or not at all
"""

import contextlib
import math
from collections.abc import Callable, Iterator
from contextvars import ContextVar
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from octmip.errors import CertificateError, DataError, ProblemError, SolverError
from octmip.input.files import write_bytes
from octmip.trees.answer.certificate import checked_leaf_index, first_forbidden_split
from octmip.trees.answer.interruption import is_heard, note
from octmip.trees.answer.solution import Progress, ProgressCallback, ProofError, Solution, Stop
from octmip.trees.encoding import IntegerCosts
from octmip.trees.nodes.reached import without_empty_sides
from octmip.trees.nodes.tree import HyperplaneSplit, Leaf, Node, goes_left, splits
from octmip.trees.question.problem import Problem

NativeProgress = Callable[[float, int, int, int], None]
"""Seconds, objective, bound and nodes, as the native core reports them."""
NO_TREE = 2**63 - 1
"""The native core's objective while it has no tree."""
MOST_WHOLE = 2**62
"""An incumbent of a higher cost is no start for the native core."""
BEGINNING = Progress(seconds=0.0, objective=math.inf, bound=-math.inf, n_nodes=0)


def check_threads(n_jobs: int) -> None:
    """Raise a `ProblemError` where less than one thread is to work."""
    if n_jobs < 1:
        raise ProblemError(f"n_jobs is {n_jobs}; expected 1 or more")


def feasible_incumbent(problem: Problem, incumbent: Node | Solution | None) -> Node | None:
    """Return the incumbent's tree without splits that part no samples; None where there is no incumbent.

    Raises
    ------
    ProblemError
        it is no tree of the problem, or a solution without a tree.
    """
    if incumbent is None:
        return None
    given = incumbent.tree if isinstance(incumbent, Solution) else incumbent
    if given is None:
        raise ProblemError("the incumbent solution holds no tree; leave it out or give a tree")
    if problem.shape.split == "axis" and any(isinstance(split, HyperplaneSplit) for split in splits(given)):
        raise _refused("it has a split over a hyperplane but split is 'axis'")
    forbidden = first_forbidden_split(problem, given)  # before samples are routed: a feature may not exist
    if forbidden:
        raise _refused(forbidden)
    tree = without_empty_sides(given, problem.samples.features)
    try:
        checked_leaf_index(problem, tree)
    except CertificateError as error:
        raise _refused(str(error)) from error
    return tree


def _refused(reason: str) -> ProblemError:
    return ProblemError(
        f"the incumbent is no tree of this problem: {reason}; give a tree within the problem's limits, or leave it out"
    )


def whole_cost(problem: Problem, costs: IntegerCosts, tree: Node) -> int:
    """Return the cost of a tree on the grid, as far as the native core takes it."""
    return min(MOST_WHOLE, costs.whole_objective(problem, tree))


def native_progress(
    progress: ProgressCallback | None, value: Callable[[int], float], before: Progress = BEGINNING
) -> NativeProgress:
    """Return what the native core is to call: it reports whole numbers, `progress` gets the problem's units.

    It also ends the search where its call was interrupted: the core itself hears of Ctrl-C in the main thread alone.

    Parameters
    ----------
    value
        what a whole number of the core is in the problem's units.
    before
        what is known and spent before the call; later reports are never worse.
    """

    def report(seconds: float, objective: int, bound: int, n_nodes: int) -> None:
        if is_heard():
            raise KeyboardInterrupt
        if progress is None:
            return
        found = math.inf if objective >= MOST_WHOLE else value(objective)
        progress(
            Progress(
                seconds=before.seconds + seconds,
                objective=min(before.objective, found),
                bound=max(before.bound, value(bound)),
                n_nodes=before.n_nodes + n_nodes,
            )
        )

    return report


def relabelled(problem: Problem, tree: Node, rows: NDArray[np.int64] | None = None) -> Node:
    """Return the tree with the label of least true cost (the first of equals) at every leaf that samples reach.

    On the grid of whole numbers light samples may cost nothing, and two labels be equal that are not.
    """
    rows = np.arange(problem.samples.n_samples) if rows is None else rows
    if isinstance(tree, Leaf):
        return Leaf(int(problem.class_costs(rows).argmin())) if len(rows) else tree
    left = goes_left(tree, problem.samples.features, rows)
    sides = [relabelled(problem, side, rows[part]) for side, part in ((tree.left, left), (tree.right, ~left))]
    return replace(tree, left=sides[0], right=sides[1])


def better(problem: Problem, found: Node, known: Node | None) -> tuple[Node, float]:
    """Return the better of two trees by the true costs, and its objective: rounded costs can rank two the wrong way."""
    objective = problem.objective(found)
    if known is not None and (least := problem.objective(known)) < objective:
        return known, least
    return found, objective


def write_log(path: Path, log: str, check: Callable[[Path], object] | None = None) -> None:
    """Write a proof log whole or not at all, and only if `check`, given a draft of it, raises nothing.

    Raises
    ------
    DataError
        the file cannot be written.
    """
    if check is None:
        write_bytes(path, log.encode("ascii"))
        return
    draft = path.with_name(path.name + ".part")
    write_bytes(draft, log.encode("ascii"))
    try:
        check(draft)
        draft.replace(path)
    finally:
        draft.unlink(missing_ok=True)


@contextlib.contextmanager
def logged(path: str | Path, stop: Stop, solution_of: Callable[[], Solution]) -> Iterator[None]:
    """Let a log be written inside; where it cannot be, nothing that was found is lost.

    Raises
    ------
    ProofError
        the search had been interrupted, writing was, or the file cannot be written; it holds the solution of
        `solution_of`.
    """
    reason = "the proof was interrupted"
    try:
        if stop is not Stop.INTERRUPTED and not is_heard():
            yield
            return
    except KeyboardInterrupt:
        note()
    except ProofError:
        raise
    except (SolverError, DataError) as error:
        reason = str(error)
    raise ProofError(f"no log is in {path}: {reason}; tree and bound stand without it", solution_of())


_SWITCHED_OFF: ContextVar[tuple[str, ...]] = ContextVar("switched_off", default=())


@contextlib.contextmanager
def without(*prunes: str) -> Iterator[None]:
    """Let searches do without some prunes: tests show so that none of them costs the optimum.

    Parameters
    ----------
    prunes
        of `_native.prunes()` or `_native.two_feature_prunes()`; an unknown one is refused by the search.
    """
    token = _SWITCHED_OFF.set(prunes)
    try:
        yield
    finally:
        _SWITCHED_OFF.reset(token)


def switched_off() -> list[str]:
    """Return the names of the prunes that are to be done without."""
    return list(_SWITCHED_OFF.get())
