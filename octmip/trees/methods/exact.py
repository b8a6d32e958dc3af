"""Branch and bound over thresholds: provably optimal axis-aligned trees. A thin wrapper of the native core.

The core counts ranks and integers (see `octmip.trees.encoding`); the algorithm, its bounds and their proofs are in
docs/theory/exact.md. Categorical features: one column of 0/1 for each category, all columns reading one sensor
(`sensor_of_feature`), so that a split asks "is it this category?" and the sensor is paid for once.
"""

import contextlib
import math
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from octmip.errors import NoTreeError, ProblemError
from octmip.input.files import check_writable
from octmip.trees import _native
from octmip.trees.answer.scope import limits_in_words
from octmip.trees.answer.solution import Limits, Progress, ProgressCallback, Solution, Stop
from octmip.trees.encoding import (
    IntegerCosts,
    Ranks,
    centred_tree,
    integer_costs,
    native_arguments,
    native_problem,
    rank_features,
    rows_from_tree,
    rules_of,
    tree_from_rows,
    with_given_thresholds,
    with_old_sides,
)
from octmip.trees.evidence.proof import log_header
from octmip.trees.methods.checkpoint.search_state import ExactState, KnownRow, StateEntry, every_of
from octmip.trees.methods.cluster import Cluster, Future
from octmip.trees.methods.native_call import (
    NO_TREE,
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
from octmip.trees.methods.shared_work import submitter
from octmip.trees.methods.ties import UNBROKEN, Effort, break_ties
from octmip.trees.nodes.tree import Node
from octmip.trees.question.problem import Problem
from octmip.trees.question.shape import MAX_DEPTH

SOLVER = "exact"


def branch_and_bound(
    problem: Problem,
    *,
    limits: Limits = Limits(),  # noqa: B008 - frozen
    incumbent: Node | Solution | None = None,
    seed: int = 0,
    n_jobs: int = 1,
    progress: ProgressCallback | None = None,
    options: ExactOptions = ExactOptions(),  # noqa: B008 (frozen)
    break_ties: bool = False,
) -> Solution:
    """Return the best axis-aligned tree of a problem and the proof's bound.

    Parameters
    ----------
    problem
        with ``split="axis"``; any weights, costs, depth, leaf size, penalty.
    limits
        seconds, relative gap, nodes (evaluated cuts), bytes of the core's own tables.
    incumbent
        a feasible tree to start from; a good one shortens the proof (`octmip.trees.solver.solve` looks for one).
    seed
        of the start's random choices.
    n_jobs
        threads. Cost, bound and tree of a finished search do not depend on it.
    progress
        called with a `Progress` about every 50 ms.
    options
        the proof's log takes a second search, about as long. ``checkpoint`` is an entry here, which keeps solved cuts
        of the root, from depth 3 on. ``cluster`` is an open `Cluster` here, whose processes solve the root's cuts, from
        depth 3 on; tree, bound and evaluated cuts are those of one machine.
    break_ties
        among the optimal trees return one of fewest splits, of those one of fewest sensors, each proven by
        more searches; `details["ties_broken"]` says what was. Thresholds are centred in any case.
        Where a shape is asked for (`Shape.is_shaped`) ties stay, and under `monotone` thresholds too.

    Raises
    ------
    ProblemError
        the problem asks for hyperplanes, or the incumbent is not one of its trees.
    ProofError
        the proof was interrupted before it could be written, or the log cannot be written: the error holds the
        solution.
    DataError
        the checkpoint holds no state of such a search.
    """
    started = time.perf_counter()
    _check(problem, n_jobs)
    proof = options.proof
    start = feasible_incumbent(problem, incumbent)
    if proof is not None:
        check_writable(proof)
    ranks = rank_features(problem)
    kept = None
    if options.checkpoint is not None and not problem.shape.is_shaped:  # such a search has no state
        kept = StateEntry(options.checkpoint, problem, ranks, every_of(options))
    search = _Search(problem, limits, n_jobs, progress, started, ranks, kept, options.cluster)
    if proof is not None:  # a log has no line for these bounds, and to search them out takes longer than the limit
        search.off = [*search.off, "level_below", "cancelling"]
    search.search(start)
    may_break = break_ties and search.stop is Stop.OPTIMAL and not problem.shape.is_shaped
    ties = search.smaller() if may_break else dict(UNBROKEN)
    if proof is not None:
        with logged(proof, search.stop, lambda: search.solution(seed, ties)):
            search.bound = search.write_proof(Path(proof))
    return search.solution(seed, ties)


@dataclass(slots=True)
class _Search:
    """A search, and again on a finer grid while rounding alone keeps the bound from the tree."""

    problem: Problem
    limits: Limits
    n_jobs: int
    progress: ProgressCallback | None
    started: float
    ranks: Ranks
    kept: StateEntry | None
    cluster: Cluster | None
    off: list[str] = field(default_factory=switched_off)
    tree: Node | None = None
    objective: float = math.inf
    bound: float = -math.inf
    stop: Stop = Stop.INTERRUPTED
    tolerance: float = 0.0
    n_nodes: int = 0
    proven: tuple[_native.Problem, IntegerCosts, int] | None = None  # of the best bound of this search
    grid: Node | None = None  # the tree from which the costs on the grid were made
    known: KnownRow | None = None  # what was last kept of this grid

    def search(self, start: Node | None) -> None:
        """Search until the bound meets the tree, or no grid of whole numbers is finer."""
        self._keep(start)
        self.grid = self.tree
        self._resume()
        costs = integer_costs(self.problem, self.grid)
        while True:
            self.stop = self._search_grid(costs)
            self._save(costs, self.known)
            if self.stop is not Stop.OPTIMAL or self._is_proven(costs):
                return
            finer = integer_costs(self.problem, self.tree)
            if finer.exponent <= costs.exponent:
                self.stop = Stop.NUMERICS
                return
            costs, self.grid, self.known = finer, self.tree, None

    def solution(self, seed: int, ties: dict[str, str]) -> Solution:
        """Return what was found and proven."""
        tree = None if self.tree is None else self.problem.with_sides(self.tree)
        if tree is not None and self.problem.shape.old_tree is not None:
            tree = with_old_sides(self.problem, tree)
        return Solution(
            tree=tree,
            objective=self.objective,
            bound=self.bound,
            stop=self.stop,
            seconds=time.perf_counter() - self.started,
            n_nodes=self.n_nodes,
            solver=SOLVER,
            version=_native.__version__,
            seed=seed,
            tolerance=self.tolerance,
            details={"ties_broken": ties} | self.scope,
        )

    def _resume(self) -> None:
        """Take up what a checkpoint holds, if there is one."""
        read = None if self.kept is None else self.kept.read_exact()
        if read is not None:
            self.grid, (self.bound, tree, self.known) = read
            self._keep(tree)

    @property
    def shape(self) -> dict[str, Any]:
        """What the native core's search for a shape is told."""
        most, directions = self.problem.shape.limited_splits, self.problem.shape.directions
        return {
            "max_splits": 2**self.problem.shape.depth - 1 if most is None else most,
            "directions": [directions[self.ranks.feature(column)] for column in range(self.ranks.n_columns)],
            "rules": rules_of(self.problem, self.ranks) if self.problem.shape.has_parts else None,
        }

    @property
    def scope(self) -> dict[str, object]:
        """Which trees the bound holds for, where it does not hold for all: deeper ones pay for as many splits."""
        holds = not self.problem.shape.any_depth or self.bound <= (MAX_DEPTH + 1) * self.problem.shape.leaf_penalty
        return (
            {}
            if holds or self.problem.shape.depth < MAX_DEPTH
            else {"scope": f"trees {limits_in_words(self.problem, MAX_DEPTH)}"}
        )

    def _save(self, costs: IntegerCosts, known: KnownRow | None) -> None:
        """Write the checkpoint: what is known of the root, the best tree within the budget, what was spent."""
        if self.kept is None:
            return
        self.known, best, n_nodes = known, self.tree, self.n_nodes
        if known is not None:
            tree = tree_from_rows(known.best[1], self.ranks)
            is_within = self.problem.shape.sensor_cost_of(tree) <= self.problem.shape.sensor_limit
            if is_within and (best is None or self.problem.objective(tree) <= self.problem.objective(best)):
                best = tree
            n_nodes = max(n_nodes, known.n_nodes)
        self.kept.write_exact(self.grid, costs, ExactState(self.bound, best, known), n_nodes)

    def _search_grid(self, costs: IntegerCosts) -> Stop:
        native = native_problem(self.problem, self.ranks, costs)
        submit = self._submit(costs, self.off)
        now = time.perf_counter()
        began = self.started if self.n_nodes else now
        first = None
        if self.tree is not None:
            first = whole_cost(self.problem, costs, self.tree), rows_from_tree(self.tree, self.ranks)
        free = self._in_no_order(native, costs, began)
        if free is not None and Stop(free.stop) is not Stop.OPTIMAL:
            return Stop(free.stop)
        before = self._state(began)
        saving = None
        if self.kept is not None:
            saving = (self.kept.every, lambda row: self._save(costs, KnownRow(**row)), self.known)
        with contextlib.nullcontext() if self.kept is None else self.kept.going_on():
            limits = self.limits.remaining(began, self.n_nodes)
            progress = native_progress(self.progress, costs.value, before)
            if not self.problem.shape.is_shaped:
                result = _native.branch_and_bound(
                    native, first, limits, self.n_jobs, self.off, progress, checkpoint=saving, submit=submit
                )
            else:
                known = None if free is None else (free.objective, free.rows)
                result = _native.shaped_search(native, first, limits, progress, free=known, **self.shape)
        self.n_nodes += result.n_nodes
        lower, stop = costs.value(result.bound), Stop(result.stop)
        if self.proven is None or lower > self.bound:
            self.proven = (native, costs, result.bound)
        self.bound = max(self.bound, lower)
        if result.objective == NO_TREE:
            return self._without_tree(stop)
        if self.problem.shape.monotone is not None:  # thresholds and labels are where the order needs them
            self._keep(tree_from_rows(result.rows, self.ranks))
            return stop
        found = centred_tree(result.rows, self.ranks, self.problem.samples.features)
        if self.problem.shape.has_parts:
            found = with_given_thresholds(self.problem, found)
        self._keep(found)
        if costs.is_rounded:
            # Samples too light for the grid still have labels; equal in float64, the grid's own are the better ones.
            self._keep(relabelled(self.problem, found), least=math.ulp(0.0))
        return stop

    def _state(self, began: float) -> Progress:
        return Progress(time.perf_counter() - began, self.objective, self.bound, self.n_nodes)

    def _in_no_order(self, native: _native.Problem, costs: IntegerCosts, began: float) -> _native.Found | None:
        """Return the best tree in no order, which often keeps the one asked for; None where it is no whole tree."""
        if self.problem.shape.monotone is None or self.problem.shape.limited_splits is not None:
            return None
        self._keep(self.problem.best_leaf())

        def shown(state: Progress) -> None:
            # The bound holds in order too, the tree does not.
            if self.progress is not None:
                self.progress(replace(state, objective=self.objective))

        limits = replace(self.limits.remaining(began, self.n_nodes), gap=0.0)
        progress = native_progress(shown, costs.value, self._state(began))
        free = _native.branch_and_bound(native, None, limits, self.n_jobs, self.off, progress)
        self.n_nodes += free.n_nodes
        self.bound = max(self.bound, costs.value(free.bound))
        return free

    def _without_tree(self, stop: Stop) -> Stop:
        """Return why a search ended that found no tree.

        Raises
        ------
        NoTreeError
            there is none.
        """
        if stop is not Stop.OPTIMAL:
            return stop
        parts = ("fixed_splits", "path_rules", "max_changes")
        asked = [name for name in parts if getattr(self.problem.shape, name) is not None]
        raise NoTreeError(
            f"no tree of depth {self.problem.shape.depth} with leaves of {self.problem.shape.leaf_size} samples or "
            f"more has what {' and '.join(asked)} asks for: a given split, or one that must stay, "
            "leaves a side empty or too small; ask for less, or give more depth"
        )

    def _keep(self, tree: Node | None, least: float = 0.0) -> None:
        """Take up a tree that is better by so much, by the true costs: rounded ones can rank two the wrong way."""
        if tree is None:
            return
        objective = self.problem.objective(tree)
        if math.isinf(self.objective) or self.objective - objective >= least:
            self.tree, self.objective = tree, objective

    def _is_proven(self, costs: IntegerCosts) -> bool:
        """Whether a search to its end proves the tree optimal: what rounding may hide is less than a sample's worth."""
        tolerance = costs.closing(self.problem, self.tree, self.objective, self.bound)
        self.tolerance = max(0.0, tolerance)
        return tolerance >= 0

    def smaller(self) -> dict[str, str]:
        """Replace the tree by a smaller one that costs the same, and return what is proven of it."""
        assert self.tree is not None
        assert self.proven is not None
        _, costs, _ = self.proven
        effort = Effort(self.started + self.limits.seconds, self.limits, self.n_jobs)
        rows, ties = break_ties(self.problem, self.ranks, costs, rows_from_tree(self.tree, self.ranks), effort)
        smaller = centred_tree(rows, self.ranks, self.problem.samples.features)
        self._keep(smaller)
        return ties if self.tree is smaller else dict(UNBROKEN)

    def _submit(
        self, costs: IntegerCosts, off: Sequence[str], *, is_logged: bool = False
    ) -> tuple[Callable[[int, Any], Future], int] | None:
        """Return what submits cuts of the root to a cluster's workers, and how many at once; None without one."""
        if self.cluster is None:
            return None
        arguments = native_arguments(self.problem, self.ranks, costs)
        return submitter(self.cluster, arguments, off, is_logged=is_logged), self.cluster.round_size

    def write_proof(self, path: Path) -> float:
        """Write a log that proves the best bound of this search, and return that bound."""
        assert self.proven is not None
        native, costs, claim = self.proven
        body = _native.prove(native, claim, self.n_jobs, submit=self._submit(costs, [], is_logged=True))
        if body is None:
            raise KeyboardInterrupt
        write_log(path, log_header(self.problem, costs, claim) + body + "end\n")
        return costs.value(claim)


def _check(problem: Problem, n_jobs: int) -> None:
    if problem.shape.split != "axis":
        raise ProblemError(
            "the exact core finds axis-aligned trees but split is 'hyperplane'; use method 'search' or 'oct_h'"
        )
    check_threads(n_jobs)
