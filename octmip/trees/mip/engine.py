"""Engine: from a formulation to a Solution by pricing, building, starting, running, decoding and re-routing.

HiGHS works in floating point with tolerances, so a "solution" of its model need not be one of the problem, and a bound
need not hold. The objective that it is given is made of whole numbers of moderate size (`octmip.trees.mip.prices`); its
bound is lowered by what its tolerances allow (`octmip.trees.mip.highs.claims`); its objective is counted from its
values; its splits become a tree, every sample is routed through that tree, and the objective is counted again. If the
count is worse than HiGHS claims, or better than it says any tree can be, the run is repeated with tighter tolerances
and without a start. What is contradicted even then is not believed: the best tree known comes back with a bound that
holds, and `Stop.NUMERICS` (`octmip.trees.mip.result`).
"""

import math
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from octmip.errors import CertificateError, SolverError
from octmip.trees.answer.certificate import checked_leaf_index
from octmip.trees.answer.scope import within
from octmip.trees.answer.solution import Limits, ProgressCallback, Solution, Stop
from octmip.trees.methods.options import MipOptions
from octmip.trees.mip.blocks.heap import Heap, Placed, place, to_tree
from octmip.trees.mip.blocks.scope import Scope
from octmip.trees.mip.columns import over_columns
from octmip.trees.mip.highs import highs, process
from octmip.trees.mip.highs.claims import Accuracy, accuracy
from octmip.trees.mip.incumbent import canonicalise, starting_tree
from octmip.trees.mip.prices import Prices, whole_prices
from octmip.trees.mip.result import Known, RunResult, solution_of
from octmip.trees.mip.rows import Rows
from octmip.trees.nodes.tree import HyperplaneSplit, Node, Split
from octmip.trees.question.problem import Problem

FINEST = 1e-9  # HiGHS's feasibility tolerance that a refuted solution is tried again with
# Above it interior points solve the first relaxation: measured on 175 x 20 thresholds, 6828 columns, 1.6 s against the
# simplex method's 14.9 CPU s.
MOST_SIMPLEX_COLUMNS = 5000
START_SLACK = 1e-7  # rows may be broken by so much in a start: rounding of x and eps
COLUMNS_OF_NODE = 8  # what lists and dictionaries of a node take, in columns
SECONDS_OF_ENTRY = 2.5e-7  # that a coefficient takes on its way from `Rows.add` to HiGHS, measured


class Formulation(Protocol):
    """A problem as rows, with the ways from a tree to a solution and back."""

    @property
    def rows(self) -> Rows:
        """The model."""

    @property
    def prices(self) -> Prices:
        """The prices that it minimises: whole numbers."""

    @property
    def heap(self) -> Heap:
        """The complete tree it is written over."""

    @property
    def scope(self) -> Scope:
        """The trees that its bound speaks about."""

    def start(self, placed: Placed) -> NDArray[np.float64] | None:
        """Return the values of a tree laid into the heap, None when the formulation does not hold that tree."""

    def splits(self, values: NDArray[np.float64]) -> Mapping[int, Split | HyperplaneSplit]:
        """Return the split of each branch node that has one (its children are not read)."""

    def labels(self, values: NDArray[np.float64]) -> Mapping[int, int]:
        """Return the label of each leaf that has one."""


@dataclass(frozen=True, slots=True)
class Request:
    """A request to the engine: everything beside the problem.

    Attributes
    ----------
    method
        name of the solver.
    limits, incumbent, seed, n_jobs, progress
        as in `octmip.trees.solver.solve`.
    options
        of the method; not all of its models have a use for each.
    """

    method: str
    limits: Limits = Limits()  # noqa: RUF009  (frozen)
    incumbent: Node | None = None
    seed: int = 0
    n_jobs: int = 1
    progress: ProgressCallback | None = None
    options: MipOptions = MipOptions()  # noqa: RUF009  (frozen)


Formulate = Callable[[Problem, Known, MipOptions], Formulation]
"""Builds a formulation of a problem from what is known, under the options of its method."""


@dataclass(frozen=True, slots=True, eq=False)
class Decoded:
    """A tree read from a solution of the model: its price there, and the tree in canonical form (never worse)."""

    price: float
    tree: Node


class LimitReachedError(SolverError):
    """A limit was reached while the model was built; caught by `solve_formulation`."""

    def __init__(self, stop: Stop) -> None:
        """Keep the limit that was reached."""
        super().__init__(f"limit of {stop} reached while the model was built")
        self.stop = stop


@dataclass(frozen=True, slots=True)
class Clock:
    """The time and memory of a run since it began, held against its limits."""

    limits: Limits
    began: float

    @property
    def seconds(self) -> float:
        """Seconds since the beginning."""
        return time.perf_counter() - self.began

    @property
    def left(self) -> Limits:
        """The limits with the time that is left."""
        return replace(self.limits, seconds=max(self.limits.seconds - self.seconds, 0.0))

    def check(self, size: float = 0.0, seconds: float = 0.0) -> None:
        """Raise when the time, or that for `seconds` more, is up, or a model of `size` bytes is too large."""
        if self.seconds + seconds > self.limits.seconds:
            raise LimitReachedError(Stop.TIME)
        if size > self.limits.memory:
            raise LimitReachedError(Stop.MEMORY)


def solver_of(method: str, formulate: Formulate) -> Callable[..., Solution]:
    """Return the solver that runs HiGHS on a formulation: of a problem, and by name the further fields of a `Request`.

    An `incumbent` is the tree to start from; without one it starts from CART's. Readings may be missing. The solver
    raises what `solve_formulation` and `formulate` raise.
    """

    @over_columns
    def solve(problem: Problem, **request: Any) -> Solution:
        return solve_formulation(problem, formulate, Request(method, **request))

    return solve


def solve_formulation(problem: Problem, formulate: Formulate, request: Request) -> Solution:
    """Solve a formulation of a problem and return the Solution.

    Raises
    ------
    ProblemError
        the incumbent is deeper than the problem allows.
    SolverError
        HiGHS cannot be run, or refuses the model.
    """
    clock = Clock(request.limits, time.perf_counter())
    process.warm()
    known = _known(problem, request, clock)
    result = RunResult(known, known.tree, Stop.TIME, {"start": {"objective": known.objective, "accepted": False}})
    try:
        check_heap(problem, known.rows)
        formulation = formulate(problem, known, request.options)
        result.better(problem, known.tree)
        clock.check(seconds=formulation.rows.n_entries * SECONDS_OF_ENTRY)
        run_formulation(problem, formulation, request, clock, result)
    except LimitReachedError as reached:
        result.stop = reached.stop
        result.details["numerics"] = str(reached)
    return solution_of(
        problem,
        result,
        method=request.method,
        seed=request.seed,
        seconds=clock.seconds,
        gap=request.limits.gap,
    )


def check_heap(problem: Problem, rows: Rows) -> None:
    """Check that the nodes alone are within the limits: their ranges can fill the memory, and no model is smaller."""
    of_node = problem.samples.n_features + problem.samples.n_samples + COLUMNS_OF_NODE
    rows.check_limits(columns=2**problem.shape.depth * of_node)


def _known(problem: Problem, request: Request, clock: Clock) -> Known:
    tree = starting_tree(problem, request.incumbent, request.seed)
    objective = problem.objective(tree)
    return Known(tree, objective, whole_prices(problem, objective), Rows(limit_check=clock.check))


def run_formulation(
    problem: Problem, formulation: Formulation, request: Request, clock: Clock, result: RunResult
) -> None:
    """Run HiGHS on a formulation, again with finer tolerances if need be, and keep the outcome in `result`."""
    rows, prices = formulation.rows, formulation.prices
    result.details |= _describe(problem, formulation, request)
    result.details["build_seconds"] = clock.seconds
    start, result.details["start"] = _start_values(problem, formulation, result.known.tree)
    exact = accuracy(rows, prices, formulation.scope.tolerance)
    # HiGHS 1.16.0 may price a start too low, and what it finds too (findings/highs_start_lowers_the_optimum.sh).
    for tolerance, values in ((exact.tolerance, start), (FINEST, None)):
        exact = replace(exact, tolerance=tolerance)
        result.refuted = _run_once(problem, formulation, request, clock, result, exact, values)
        if not result.refuted:
            return


def _start_values(
    problem: Problem, formulation: Formulation, tree: Node
) -> tuple[NDArray[np.float64] | None, dict[str, object]]:
    """Return the values of the starting tree, None where the model does not hold it, and the details of the start."""
    said: dict[str, object] = {"objective": problem.objective(tree), "accepted": False}
    values = formulation.start(place(tree, formulation.heap, problem.samples.features))
    if values is None:
        return None, said | {"reason": f"outside the model, which holds {formulation.scope.trees}"}
    worst, where = formulation.rows.violation(values)
    if worst > START_SLACK:
        return None, said | {"reason": f"breaks row {where} by {worst:.3g}"}
    return values, said


def _run_once(
    problem: Problem,
    formulation: Formulation,
    request: Request,
    clock: Clock,
    result: RunResult,
    exact: Accuracy,
    start: NDArray[np.float64] | None,
) -> str:
    """Run HiGHS once, keep the believed part of its outcome in `result`, and return why the rest is not, or ""."""
    rows, prices = formulation.rows, formulation.prices
    options = highs.Options(
        limits=clock.left,
        seed=request.seed,
        threads=request.n_jobs,
        tolerance=exact.tolerance,
        dual_tolerance=exact.dual_tolerance,
        absolute_gap=exact.absolute_gap,
        lp_solver="ipm" if rows.n_columns > MOST_SIMPLEX_COLUMNS else "choose",
        further=request.options.highs or {},
        log=request.options.log,
    )
    progress = None if request.progress is None else _in_true_units(prices, request.progress, clock)
    outcome = highs.run(rows, options, start=start, progress=progress)
    _note_run(result, outcome, start, formulation, exact)
    result.stop, result.n_nodes, result.price_bound = outcome.stop, outcome.n_nodes, exact.bound(outcome)
    if outcome.stop is Stop.NUMERICS:
        return f"HiGHS ended with {outcome.status}"
    if outcome.values is None:
        return ""
    decoded = decode(problem, formulation, outcome.values)
    reason = refutation(problem, outcome, result.price_bound, decoded)
    try:
        checked_leaf_index(problem, decoded.tree)
    except CertificateError as error:
        return reason or f"HiGHS's tree is no tree of the problem: {error}"
    result.better(problem, decoded.tree)
    result.is_outside = _is_outside(problem, formulation, result.tree)
    return reason


def _is_outside(problem: Problem, formulation: Formulation, tree: Node) -> bool:
    """Whether a tree is none of those that the model holds, where it does not hold all."""
    placed = place(tree, formulation.heap, problem.samples.features)
    return not formulation.scope.is_whole and formulation.start(placed) is None


def _note_run(
    result: RunResult,
    outcome: highs.Outcome,
    start: NDArray[np.float64] | None,
    formulation: Formulation,
    exact: Accuracy,
) -> None:
    result.details["tolerance"] = exact.tolerance
    result.details["status"] = outcome.status
    shown = formulation.prices.true(outcome.root_bound)
    result.details["root_bound"] = shown if math.isfinite(shown) else None
    if start is not None:
        first = min(outcome.first_incumbent, outcome.objective)
        said = result.details["start"]
        assert isinstance(said, dict)
        said["accepted"] = bool(first <= formulation.rows.objective(start) + 0.5)


def _in_true_units(prices: Prices, progress: ProgressCallback, clock: Clock) -> ProgressCallback:
    """Return the callback for states of HiGHS: in the problem's units, in seconds since the run began."""
    return lambda state: progress(
        replace(
            state,
            seconds=clock.seconds,
            objective=prices.true(state.objective),
            bound=prices.true(state.bound),
        )
    )


def decode(problem: Problem, formulation: Formulation, values: NDArray[np.float64]) -> Decoded:
    """Return the tree that a solution stands for, every sample re-routed through it."""
    raw = to_tree(formulation.heap, formulation.splits(values), formulation.labels(values))
    return Decoded(formulation.prices.of_tree(problem, raw), canonicalise(problem, raw))


def refutation(problem: Problem, outcome: highs.Outcome, bound: float, decoded: Decoded) -> str:
    """Return why HiGHS's price or bound cannot be true of its solution, or of the decoded tree, "" when they can."""
    if outcome.objective > outcome.claimed + 0.5:
        return f"HiGHS claims objective {outcome.claimed} but its own solution has {outcome.objective}"
    if decoded.price > outcome.objective + 0.5:
        return (
            f"HiGHS claims objective {outcome.objective} but its tree costs {decoded.price} "
            f"when all {problem.samples.n_samples} samples are routed through it"
        )
    if decoded.price < bound - 0.5:
        return f"HiGHS claims that no tree is below {bound} but its own costs {decoded.price}"
    return ""


def _describe(problem: Problem, formulation: Formulation, request: Request) -> dict[str, object]:
    rows, prices = formulation.rows, formulation.prices
    return {
        "scope": within(problem, formulation.scope.trees),
        **formulation.scope.notes,
        "model": {
            "rows": rows.n_rows,
            "columns": rows.n_columns,
            "integers": int(rows.is_integer.sum()),
            "nonzeros": int(rows.matrix().nnz),
        },
        "prices": {"unit": float(prices.unit), "rounding": float(prices.above + prices.below)},
    }
