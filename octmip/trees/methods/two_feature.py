"""Optimal trees whose splits use one or two features, proven by branch and bound: a wrapper of the native core.

    minimise  the objective of the Problem
    over      trees of depth 1 to 3 whose splits are lines  a x_f + b x_g = c  or thresholds  x_f = c

The bound holds for every tree whose lines are taken in exact arithmetic over the float64 values as given: nothing is
rounded to a grid. Coordinates scaled to [0, 1] settle all samples that keep 2^-42 clear of a line; the few others are
parted in whole numbers of as many bits as it takes. A dichotomy that no float64 line makes with that much room is
numerically undecided: it counts for the bound but is not returned, and `Stop.NUMERICS` and
`Solution.details["numerically_undecided"]` report it. See docs/theory/two-feature.md.
"""

import contextlib
import time
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from octmip.errors import CertificateError, ProblemError
from octmip.input.files import check_writable
from octmip.trees import _native
from octmip.trees.answer.solution import Limits, ProgressCallback, ProofError, Solution, Stop
from octmip.trees.encoding import (
    IntegerCosts,
    integer_costs,
    native_problem,
    rank_features,
    tree_from_rows,
)
from octmip.trees.evidence.proof import check_proof, log_header
from octmip.trees.methods.checkpoint.search_state import StateEntry, TwoFeatureState, every_of
from octmip.trees.methods.native_call import (
    better,
    check_threads,
    feasible_incumbent,
    logged,
    native_progress,
    relabelled,
    switched_off,
    whole_cost,
    write_log,
)
from octmip.trees.methods.options import ExactOptions
from octmip.trees.nodes.digits import midpoint
from octmip.trees.nodes.tree import HyperplaneSplit, Leaf, Node, Split, goes_left
from octmip.trees.question.problem import Problem

SOLVER = "two-feature exact"
MOST_DEPTH, MOST_LOGGED = 3, 2
"""Of trees that are proven, and of those with a log, a checkpoint, a sensor budget or whole coefficients."""
MOST_FEATURES = 2


def two_feature_branch_and_bound(
    problem: Problem,
    *,
    limits: Limits = Limits(),  # noqa: B008 (frozen)
    incumbent: Node | Solution | None = None,
    seed: int = 0,
    n_jobs: int = 1,
    progress: ProgressCallback | None = None,
    options: ExactOptions = ExactOptions(),  # noqa: B008 (frozen)
) -> Solution:
    """Return a proven optimal tree, or the best tree and the bound when a limit is reached.

    Parameters
    ----------
    problem
        of depth 1 to 3 and at most two features per split (`split_size=2`, or no more than two features).
    limits
        when to stop early.
    incumbent
        a tree of this problem; the result is never worse.
    seed
        has no effect on the optimum; kept in the solution.
    n_jobs
        threads; the result does not depend on them.
    progress
        called every few hundredths of a second.
    options
        the proof's log takes a second search, about as long, and is written once the checker accepts it, which takes
        up to ten times as long. ``checkpoint`` is an entry here, which keeps the open nodes of a proof of depth 2.

    Raises
    ------
    ProblemError
        the problem is deeper, allows more features in a split, or the incumbent is none of its trees.
    ProofError
        the proof was interrupted, rounding leaves no room for it, or the log cannot be written; the error holds
        the solution.
    DataError
        the checkpoint holds no state of such a search.
    """
    proof = options.proof
    _check(problem, n_jobs, has_log=proof is not None)
    if proof is not None:
        check_writable(proof)
    start, known = time.perf_counter(), feasible_incumbent(problem, incumbent)
    ranks, kept, state, first = rank_features(problem), None, None, known
    costs = integer_costs(problem, first)
    has_state = problem.shape.depth == MOST_LOGGED  # one level is one scan, and three keep none
    if options.checkpoint is not None and has_state:
        kept = StateEntry(options.checkpoint, problem, ranks, every_of(options))
        if (read := kept.read_two_feature()) is not None:
            first, costs, state = read
    before = 0 if state is None else state.n_nodes

    def save(row: dict[str, Any]) -> None:
        assert kept is not None
        kept.write_two_feature(first, costs, TwoFeatureState(**row))

    native = native_problem(problem, ranks, costs)
    call = (
        native,
        None if first is None else whole_cost(problem, costs, first),
        # What was spent on ranks counts, too.
        replace(limits, nodes=limits.nodes + before).remaining(start),
        n_jobs,
        seed % 2**64,
        switched_off(),
        native_progress(progress, costs.value),
    )
    with contextlib.nullcontext() if kept is None else kept.going_on():
        result = _native.two_feature_branch_and_bound(
            *call,
            checkpoint=None if kept is None else (kept.every, save, state),
        )
    found = _centred(relabelled(problem, tree_from_rows(result.rows, ranks)), problem.samples.features)
    tree, objective = better(problem, better(problem, found, first)[0], known)
    bound, stop = result.bound, result.stop
    lower = costs.value(bound)
    # Unless a limit ended the search, only rounding is left between bound and tree: a proof where it hides no sample.
    tolerance = costs.closing(problem, tree, objective, lower)
    met = tolerance >= 0.0 and (stop == Stop.OPTIMAL or lower >= objective)
    solution = Solution(
        tree=tree,
        objective=objective,
        bound=lower,
        stop=Stop.OPTIMAL if met else _open_stop(problem, stop),
        seconds=time.perf_counter() - start,
        n_nodes=result.n_nodes - before,
        solver=SOLVER,
        version=_native.__version__,
        seed=seed,
        tolerance=tolerance if met else 0.0,
        details=_details(problem, is_open=not met and stop == "finished"),
    )
    if proof is not None:
        with logged(proof, Stop(stop), lambda: solution):
            _write_proof(problem, native, costs, bound, (solution, n_jobs), Path(proof))
        return replace(solution, seconds=time.perf_counter() - start)
    return solution


def _open_stop(problem: Problem, stop: str) -> Stop:
    """Return why a search that did not meet its bound ended: a limit, or all nodes done and rounding in the way."""
    if stop not in ("optimal", "finished"):
        return Stop(stop)
    return Stop.NUMERICS if problem.shape.integer_normals is None else Stop.FINISHED


def _details(problem: Problem, *, is_open: bool) -> dict[str, object]:
    details: dict[str, object] = {"arithmetic": "float64 as given"}
    if problem.shape.integer_normals is not None:
        # Trees of real coefficients include those of whole ones: their bound holds, but need not be met.
        return details | {"coefficients": "whole; the bound is that of real ones"}
    return details | {"numerically_undecided": is_open}


def _check(problem: Problem, n_jobs: int, *, has_log: bool) -> None:
    shape = problem.shape
    asked = {
        "a proof log": has_log,
        "a sensor budget": shape.sensor_budget is not None,
        "whole coefficients": shape.integer_normals is not None,
    }
    if shape.depth > MOST_DEPTH:
        raise ProblemError(
            f"depth is {shape.depth} but two-feature trees are proven to depth {MOST_DEPTH}; take method='search'"
        )
    for words in (words for words, is_asked in asked.items() if is_asked and shape.depth > MOST_LOGGED):
        raise ProblemError(
            f"depth is {shape.depth} and {words} is asked for, which two-feature trees have to depth {MOST_LOGGED}; "
            "leave it out"
        )
    if shape.max_split_size > MOST_FEATURES:
        raise ProblemError(
            f"a split may have {shape.max_split_size} features; expected at most {MOST_FEATURES}; say split_size=2"
        )
    check_threads(n_jobs)


def _write_proof(
    problem: Problem,
    native: _native.Problem,
    costs: IntegerCosts,
    claim: int,
    given: tuple[Solution, int],
    path: Path,
) -> None:
    """Write the log of a claim, if the checker accepts it; else raise a `ProofError`."""
    solution, n_jobs = given
    body = _native.prove_two_feature(native, claim, n_jobs)
    if body is None:
        raise _no_log(
            path, "it was interrupted, the budget allows too many sets of sensors, or rounding decides", solution
        )
    header = log_header(problem, costs, claim)

    def check(draft: Path) -> None:
        check_proof(problem, draft, bound=solution.bound, n_jobs=n_jobs)

    try:
        write_log(path, header + body + "end\n", check)
    except CertificateError as error:
        raise _no_log(path, f"the checker refuses it ({error})", solution) from error


def _no_log(path: Path, reason: str, solution: Solution) -> ProofError:
    return ProofError(
        f"{path} is not written: expected a log of the bound {solution.bound}, but {reason}; tree and bound stand "
        "without it: leave the proof out, or round values that differ by less than 1e-12 of their range",
        solution,
    )


def _centred(tree: Node, features: NDArray[np.float64]) -> Node:
    """Return the tree with planes over one feature as thresholds, and those midway between the node's own samples."""
    if isinstance(tree, Leaf):
        return tree
    left = goes_left(tree, features)
    below, above = _centred(tree.left, features[left]), _centred(tree.right, features[~left])
    if isinstance(tree, HyperplaneSplit) and len(tree.features) == 2:
        return replace(tree, left=below, right=above)
    values = features[:, tree.features[0]]
    if isinstance(tree, HyperplaneSplit) and tree.coefficients[0] < 0:
        below, above, left = above, below, ~left
    return Split(tree.features[0], midpoint(float(values[left].max()), float(values[~left].min())), below, above)
