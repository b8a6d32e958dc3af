"""Engine: from a formulation to a Solution: start, run, decode, re-route every sample, refuse what disagrees.

HiGHS works in floating point with tolerances, so a "solution" of its model need not be one of the problem. Nothing of
it is believed: its splits become a tree, every sample is routed through that tree, and the objective is counted anew.
If the count is worse than HiGHS claims, or better than HiGHS says any tree can be, the run is repeated with tighter
tolerances, and at last refused with both numbers.
"""

import math
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from octmip.cart import greedy_tree
from octmip.errors import ProblemError, SolverError
from octmip.mip import highs
from octmip.mip.heap import Heap, Placed, lift, place
from octmip.mip.rows import Rows
from octmip.problem import Problem
from octmip.solution import Limits, ProgressCallback, Solution, Stop
from octmip.tree import HyperplaneSplit, Node, Split, depth, leaf_index, leaves, predict, simplify, without_empty_sides

FINEST = 1e-9  # HiGHS's feasibility tolerance that a refuted solution is tried again with
# Above it interior points solve the first relaxation: measured on 175 x 20 thresholds, 6828 columns, 1.6 s against the
# simplex method's 14.9 CPU s.
MOST_SIMPLEX_COLUMNS = 5000
START_SLACK = 1e-7  # rows may be broken by so much in a start: rounding of x and eps


class Formulation(Protocol):
    """A problem as rows, with the ways from a tree to a solution and back."""

    @property
    def rows(self) -> Rows:
        """The model."""

    @property
    def heap(self) -> Heap:
        """The complete tree it is written over."""

    @property
    def scope(self) -> str:
        """The trees that its bound speaks about, in words."""

    @property
    def tolerance(self) -> float:
        """The feasibility tolerance that its numbers need."""

    @property
    def notes(self) -> Mapping[str, object]:
        """What else is to be said about it in a Solution."""

    def start(self, placed: Placed) -> NDArray[np.float64] | None:
        """Return the values of a tree laid into the heap, None when the formulation does not hold that tree."""

    def splits(self, values: NDArray[np.float64]) -> Mapping[int, Split | HyperplaneSplit]:
        """Return the split of each branch node that has one (its children are not read)."""

    def labels(self, values: NDArray[np.float64]) -> Mapping[int, int]:
        """Return the label of each leaf that has one."""


@dataclass(frozen=True, slots=True)
class Request:
    """What is asked of the engine beside the problem.

    Attributes:
        method: name of the solver.
        limits, incumbent, seed, n_jobs, progress: as in `octmip.solver.solve`.
        lower_bound: a bound proven elsewhere, for instance by `octmip.exact`; enters the model as the bound of a column
            that is the objective, and is named in the details.
        inject: asked for a better tree while HiGHS runs, with the best objective so far; None when it has none.
        write: file to write the model to (.mps or .lp) before it is solved.
        relaxation: also solve the linear relaxation, for the details.
    """

    method: str
    limits: Limits = Limits()  # noqa: RUF009  (frozen)
    incumbent: Node | None = None
    seed: int = 0
    n_jobs: int = 1
    progress: ProgressCallback | None = None
    lower_bound: float = -math.inf
    inject: Callable[[float], Node | None] | None = None
    write: Path | str | None = None
    relaxation: bool = False


@dataclass(frozen=True, slots=True, eq=False)
class Decoded:
    """A tree read from a solution of the model: as the model means it, and tidied (never worse)."""

    raw_objective: float
    tree: Node
    objective: float


def drive(problem: Problem, encode: Callable[[Node], Formulation], request: Request) -> Solution:
    """Solve a formulation of a problem and return the Solution.

    Args:
        encode: builds the formulation; is given the best tree known, by which it may leave out what cannot be better.

    Raises:
        ProblemError: the incumbent is deeper than the problem allows, or the lower bound is none.
        SolverError: HiGHS failed, or its solution is refuted at the tightest tolerance.
    """
    began = time.perf_counter()
    best = _starting_tree(problem, request)
    if request.lower_bound > objective_of(problem, best) * (1 + 1e-9):
        raise ProblemError(
            f"lower_bound is {request.lower_bound} but a tree of objective {objective_of(problem, best)} is known; "
            "it is no bound of this problem"
        )
    formulation = encode(best)
    if not math.isinf(request.lower_bound):
        formulation.rows.bound_objective(request.lower_bound)
    if request.write is not None:
        highs.write(formulation.rows, Path(request.write))
    details = _describe(problem, formulation, request)
    details["build_seconds"] = time.perf_counter() - began
    start, details["start"] = _start_values(problem, formulation, best)
    outcome, decoded = _run_until_sound(problem, formulation, request, start, began, details)
    if decoded is not None and decoded.objective < objective_of(problem, best):
        best = decoded.tree
    return _solution(problem, best, outcome, request, time.perf_counter() - began, details)


def objective_of(problem: Problem, tree: Node) -> float:
    """Return the objective of a tree, every sample routed."""
    return problem.objective_of(tree, predict(tree, problem.features))


def _starting_tree(problem: Problem, request: Request) -> Node:
    tree = request.incumbent
    if tree is None:
        tree = greedy_tree(problem, seed=request.seed).tree
    assert tree is not None
    tree = tidy(problem, tree)
    if depth(tree) > problem.depth:
        raise ProblemError(f"the incumbent has depth {depth(tree)} but the problem allows {problem.depth}")
    return tree


def tidy(problem: Problem, tree: Node) -> Node:
    """Return the tree without empty sides, with the best label at every leaf, and equal leaves merged: never worse."""
    return simplify(relabelled(problem, without_empty_sides(tree, problem.features)))


def relabelled(problem: Problem, tree: Node) -> Node:
    """Return the tree with the label of least cost at every leaf that a sample reaches (the first of equals)."""
    index = leaf_index(tree, problem.features)
    labels = [leaf.label for leaf in leaves(tree)]
    for i in range(len(labels)):
        rows = np.flatnonzero(index == i)
        if len(rows):
            labels[i] = int(problem.class_costs(rows).argmin())
    remaining = iter(labels)

    def build(node: Node) -> Node:
        if isinstance(node, Split | HyperplaneSplit):
            left = build(node.left)
            return replace(node, left=left, right=build(node.right))
        return replace(node, label=next(remaining))

    return build(tree)


def _start_values(
    problem: Problem, formulation: Formulation, tree: Node
) -> tuple[NDArray[np.float64] | None, dict[str, object]]:
    """Return the values of the starting tree and what is to be said about it."""
    said: dict[str, object] = {"objective": objective_of(problem, tree), "accepted": False}
    values = formulation.start(place(tree, formulation.heap, problem.features))
    if values is None:
        return None, said | {"reason": f"outside the model, which holds {formulation.scope}"}
    values = formulation.rows.completed(values)
    worst, where = formulation.rows.violation(values)
    if worst > START_SLACK:
        return None, said | {"reason": f"breaks row {where} by {worst:.3g}"}
    return values, said


def _run_until_sound(
    problem: Problem,
    formulation: Formulation,
    request: Request,
    start: NDArray[np.float64] | None,
    began: float,
    details: dict[str, object],
) -> tuple[highs.Outcome, Decoded | None]:
    refuted = ""
    for tolerance in dict.fromkeys((formulation.tolerance, FINEST)):
        left = max(request.limits.seconds - (time.perf_counter() - began), 0.0)
        options = highs.Options(
            limits=replace(request.limits, seconds=left),
            seed=request.seed,
            threads=request.n_jobs,
            tolerance=tolerance,
            absolute_gap=0.999 if problem.has_integer_costs else 1e-7,
            lp_solver="ipm" if formulation.rows.n_columns > MOST_SIMPLEX_COLUMNS else "choose",
        )
        inject = None if request.inject is None else _injector(problem, formulation, request.inject)
        outcome = highs.run(formulation.rows, options, start=start, progress=request.progress, inject=inject)
        _note_run(details, outcome, start, formulation.rows, tolerance)
        if outcome.values is None:
            return outcome, None
        decoded = decode(problem, formulation, outcome.values)
        refuted = refutation(problem, outcome.objective, outcome.bound, decoded)
        if not refuted:
            return outcome, decoded
    raise SolverError(
        f"{request.method}: {refuted}, even at feasibility tolerance {FINEST}; the numbers of this problem are "
        "too close for HiGHS; solve it by method='exact' or round the features"
    )


def _note_run(
    details: dict[str, object],
    outcome: highs.Outcome,
    start: NDArray[np.float64] | None,
    rows: Rows,
    tolerance: float,
) -> None:
    details["tolerance"] = tolerance
    details["root_bound"] = outcome.root_bound if math.isfinite(outcome.root_bound) else None
    if start is not None:
        first = min(outcome.first_incumbent, outcome.objective)
        said = details["start"]
        assert isinstance(said, dict)
        said["accepted"] = bool(first <= rows.objective(start) + 1e-6)


def decode(problem: Problem, formulation: Formulation, values: NDArray[np.float64]) -> Decoded:
    """Return the tree that a solution stands for, every sample re-routed through it."""
    raw = lift(formulation.heap, formulation.splits(values), formulation.labels(values))
    tree = tidy(problem, raw)
    return Decoded(objective_of(problem, raw), tree, objective_of(problem, tree))


def refutation(problem: Problem, claimed: float, bound: float, decoded: Decoded) -> str:
    """Return a sentence when HiGHS's objective or bound cannot be true of the decoded tree, '' when they can."""
    slack = 1e-5 * max(1.0, abs(claimed)) if not problem.has_integer_costs else 0.5
    if decoded.raw_objective > claimed + slack:
        return (
            f"HiGHS claims objective {claimed} but its tree costs {decoded.raw_objective} "
            f"when all {problem.n_samples} samples are routed through it"
        )
    if decoded.raw_objective < bound - slack:
        return f"HiGHS claims that no tree is below {bound} but its own costs {decoded.raw_objective}"
    return ""


def _injector(
    problem: Problem, formulation: Formulation, source: Callable[[float], Node | None]
) -> Callable[[float], NDArray[np.float64] | None]:
    def give(best: float) -> NDArray[np.float64] | None:
        tree = source(best)
        if tree is None:
            return None
        tree = tidy(problem, tree)
        if depth(tree) > formulation.heap.depth or objective_of(problem, tree) >= best:
            return None
        values = formulation.start(place(tree, formulation.heap, problem.features))
        if values is None:
            return None
        values = formulation.rows.completed(values)
        return values if formulation.rows.violation(values)[0] <= START_SLACK else None

    return give


def _describe(problem: Problem, formulation: Formulation, request: Request) -> dict[str, object]:
    rows = formulation.rows
    details: dict[str, object] = {
        "scope": formulation.scope,
        **formulation.notes,
        "model": {
            "rows": rows.n_rows,
            "columns": rows.n_columns,
            "integers": int(rows.is_integer.sum()),
            "nonzeros": int(rows.matrix().nnz),
        },
    }
    if not math.isinf(request.lower_bound):
        details["lower_bound_given"] = request.lower_bound
    if request.relaxation:
        bound = highs.relax(rows, request.limits.seconds)
        details["relaxation_bound"] = bound if math.isfinite(bound) else None
    return details


def _solution(
    problem: Problem, tree: Node, outcome: highs.Outcome, request: Request, seconds: float, details: dict[str, object]
) -> Solution:
    objective = objective_of(problem, tree)
    tolerance = 0.0 if problem.has_integer_costs else 1e-6 * max(1.0, objective)
    bound = max(outcome.bound, request.lower_bound)
    if problem.has_integer_costs and math.isfinite(bound):
        bound = math.ceil(bound - 1e-5)
    # Weights, costs and penalty are never negative. The bound may lie above a tree that the model leaves out (OCT-H's
    # narrow bands); above the model's own tree it is refused before (`refutation`).
    bound = min(max(bound, 0.0), objective)
    if bound >= objective - tolerance:
        stop = Stop.OPTIMAL
    else:
        stop = Stop.GAP if outcome.stop is Stop.OPTIMAL else outcome.stop
    details |= normalised(problem, objective)
    return Solution(
        tree=tree,
        objective=objective,
        bound=float(bound),
        stop=stop,
        seconds=seconds,
        n_nodes=outcome.n_nodes,
        solver=request.method,
        version=f"HiGHS {highs.VERSION}",
        seed=request.seed,
        tolerance=tolerance,
        details=details,
    )


def normalised(problem: Problem, objective: float) -> dict[str, object]:
    """Return Bertsimas & Dunn's form of an objective: divided by the baseline, with alpha = leaf_penalty / baseline."""
    baseline = problem.baseline
    if baseline == 0:
        return {"baseline": 0.0, "alpha": None, "normalised_objective": None}
    return {
        "baseline": baseline,
        "alpha": problem.leaf_penalty / baseline,
        "normalised_objective": objective / baseline,
    }
