"""The tree of least worst case while gauges are off: local search, and the proof to depth 2 by the native core.

The core counts ranks and whole numbers, as the exact core does (`octmip.trees.encoding`); ranks are those of the
lowest, the true and the highest readings together, so that every threshold that makes a difference is a cut. The
algorithm and its proof are in docs/theory/worst-case.md. Beyond depth 2 the bound is that of the problem without
reading errors.
"""

import math
import time
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from octmip.errors import CertificateError, ProblemError, SolverError
from octmip.trees import _native
from octmip.trees.certificate import checked_leaf_index
from octmip.trees.encoding import (
    IntegerCosts,
    NodeRow,
    Ranks,
    integer_costs,
    native_problem,
    rows_from_tree,
    tree_from_rows,
)
from octmip.trees.methods.native_call import native_progress
from octmip.trees.problem import Problem
from octmip.trees.registry import refuse_numbers
from octmip.trees.solution import Limits, Progress, ProgressCallback, Solution, Stop, closing_tolerance
from octmip.trees.solver import solve as solve_plain
from octmip.trees.tree import Node, complexity, depth, without_empty_sides
from octmip.trees.worst_case.bands import Amount, Bands
from octmip.trees.worst_case.recount import WorstCase, certify_worst_case, most_paid, sets_off, worst_case

SOLVER = "worst case"
PROVEN_DEPTH = 2
FIRST_SHARE = 0.2
"""Share of the time that the tree without reading errors may take, and the local search after it, each."""
ROUNDS = {1: 5, 2: 10}
MORE_ROUNDS = 30
"""Perturbations of the local search, by depth; more where no proof follows."""
FIRST_SECONDS = 5.0
"""Most seconds of the local search before a proof."""


@dataclass(frozen=True, slots=True)
class WorstCaseSolution:
    """A tree of least worst case.

    Attributes
    ----------
    solution
        its objective is the worst case, its bound one of the worst case of every tree of the problem.
    figures
        what the tree costs plain, in the worst case, and under the worst constant error.
    plain_bound
        proven for the objective of every tree without reading errors: the price of surviving them is at most
        ``figures.plain - plain_bound``.
    """

    solution: Solution
    figures: WorstCase
    plain_bound: float


def solve(
    problem: Problem,
    bands: Amount | Mapping[str, Amount],
    off: int = 1,
    limits: Limits = Limits(),  # noqa: B008 - frozen
    *,
    incumbent: Node | Solution | None = None,
    seed: int = 0,
    n_jobs: int = 1,
    progress: ProgressCallback | None = None,
) -> WorstCaseSolution:
    """Return the tree of least worst case when any `off` of the gauges that it reads are off within their bands.

    Parameters
    ----------
    problem
        with ``split="axis"``; any weights, costs, leaf size (of the true readings), penalty and sensor budget.
    bands
        how far readings may be off: one amount for all gauges, or amounts by sensor or feature, each a number for both
        sides or a pair (most below, most above). A gauge that is not named is never off.
    off
        at most so many sensors are off at a time; a sensor of several features moves each within its band.
    limits
        seconds, relative gap, nodes (cuts of the root), memory. Reaching one is no error.
    incumbent
        a tree of the problem to start from.
    seed
        of the local search.
    n_jobs
        threads of the proof.
    progress
        called with a `Progress` about every 50 ms.

    Raises
    ------
    ProblemError
        the bands, `off` or the incumbent do not fit the problem, or splits are hyperplanes.
    """
    refuse_numbers(problem, "worst_case")
    started = time.perf_counter()
    search = _Search(problem, Bands.of(problem, bands), off, limits, started, seed, n_jobs, progress)
    search.run(incumbent)
    solution = search.solution()
    try:
        figures = certify_worst_case(problem, solution, bands, off)
    except CertificateError as error:
        raise SolverError(f"the search returned a tree that its certificate refutes: {error}") from error
    return WorstCaseSolution(solution, figures, search.plain.bound)


class _Search:
    """A search: the best tree, the bound, and what is left of the limits."""

    def __init__(
        self,
        problem: Problem,
        bands: Bands,
        off: int,
        limits: Limits,
        started: float,
        seed: int,
        n_jobs: int,
        progress: ProgressCallback | None,
    ) -> None:
        self.problem, self.bands, self.off, self.limits = problem, bands, off, limits
        self.started, self.seed, self.n_jobs, self.progress = started, seed, n_jobs, progress
        self.tree: Node | None = None
        self.objective, self.bound, self.tolerance = math.inf, -math.inf, 0.0
        self.stop, self.n_nodes = Stop.FINISHED, 0

    @property
    def seconds_left(self) -> float:
        """What is left of the time."""
        return max(0.0, self.limits.seconds - (time.perf_counter() - self.started))

    @property
    def is_over(self) -> bool:
        """Whether nothing is left to do, or to do it in."""
        return self.stop in (Stop.INTERRUPTED, Stop.NODES, Stop.MEMORY) or self.bound >= self.objective

    def run(self, incumbent: Node | Solution | None) -> None:
        """Search, and prove where the tree is shallow enough."""
        self.start(incumbent)
        if self.problem.depth > PROVEN_DEPTH and not self.is_over:
            self._start_shallower()
        if not self.is_over:
            self.improve()
        if self.problem.depth <= PROVEN_DEPTH and not self.is_over:
            self.prove()

    def start(self, incumbent: Node | Solution | None) -> None:
        """Take the incumbent and the best tree without reading errors, which also gives the first bound."""
        limits = replace(self.limits, seconds=self.limits.seconds * FIRST_SHARE, gap=0.0)
        given = self._checked(incumbent)
        self.plain = solve_plain(self.problem, "exact", limits, given, self.seed, self.n_jobs)
        self.bound = self.plain.bound
        if self.plain.stop is Stop.INTERRUPTED:
            self.stop = Stop.INTERRUPTED
        for tree in (given, self.plain.tree):
            self._keep(tree)

    def _start_shallower(self) -> None:
        """Take the best tree of as many levels as a proof takes: what reading errors cost shows first at the top."""
        shallower = replace(self.problem, depth=PROVEN_DEPTH)
        limits = replace(self.limits, seconds=self.seconds_left * FIRST_SHARE, gap=0.0)
        now = time.perf_counter()
        search = _Search(shallower, self.bands, self.off, limits, now, self.seed, self.n_jobs, None)
        search.run(self.tree if self.tree is not None and depth(self.tree) <= PROVEN_DEPTH else None)
        self._keep(search.tree)
        if search.stop is Stop.INTERRUPTED:
            self.stop = Stop.INTERRUPTED

    def _checked(self, incumbent: Node | Solution | None) -> Node | None:
        tree = incumbent.tree if isinstance(incumbent, Solution) else incumbent
        if tree is None:
            return None
        try:
            checked_leaf_index(self.problem, tree)
        except CertificateError as error:
            raise ProblemError(f"the incumbent is no tree of this problem: {error}") from error
        return tree

    def _keep(self, tree: Node | None) -> None:
        if tree is None:
            return
        worst = worst_case(self.problem, tree, self.bands, self.off).worst
        if worst < self.objective:
            self.tree, self.objective = tree, worst

    @cached_property
    def native(self) -> "_NativeDrift":
        """The problem as the core holds it."""
        return _NativeDrift.of(self.problem, self.bands, self.off)

    def improve(self) -> None:
        """Search for better trees by changing one node at a time."""
        native = self.native
        share = self.seconds_left
        if self.problem.depth <= PROVEN_DEPTH:
            share = min(FIRST_SECONDS, share * FIRST_SHARE)
        rounds = ROUNDS.get(self.problem.depth, MORE_ROUNDS)
        assert self.tree is not None
        starts = [native.incumbent(tree)[1] for tree in dict.fromkeys((self.tree, self.plain.tree)) if tree is not None]
        limits = replace(self.limits, seconds=share, gap=0.0, nodes=math.inf)
        rows, _, stop = _native.worst_case_search(native.problem, native.bands, starts, rounds, self.seed, limits)
        self._keep(tree_from_rows(rows, native.ranks))
        if Stop(stop) is not Stop.FINISHED:
            self.stop = Stop(stop)

    def prove(self) -> None:
        """Search all trees by branch and bound."""
        native, costs = self.native, self.native.costs
        assert self.tree is not None
        now = time.perf_counter() - self.started
        before = Progress(now, self.objective, self.bound, self.n_nodes)
        limits = replace(self.limits, seconds=self.seconds_left)
        found = _native.worst_case(
            native.problem,
            native.bands,
            native.incumbent(self.tree),
            -1,
            limits,
            self.n_jobs,
            native_progress(self.progress, costs.value, before),
        )
        tree = tree_from_rows(found.rows, native.ranks)
        if (cost := native.cost(tree)) != found.objective:
            raise SolverError(f"the core counts {found.objective} for its tree, recounted {cost}; please report this")
        self._keep(tree)
        self.bound, self.n_nodes = max(self.bound, costs.value(found.bound)), found.n_nodes
        self.stop = Stop(found.stop)
        if costs.is_rounded and self.stop is Stop.OPTIMAL:
            tolerance = closing_tolerance(self.objective, self.bound, self.problem.least_saving)
            self.tolerance, self.stop = max(0.0, tolerance), Stop.NUMERICS if tolerance < 0 else Stop.OPTIMAL

    def solution(self) -> Solution:
        """Return the best tree with the bound, and why the search ended."""
        if self.bound >= self.objective - self.tolerance and self.stop is not Stop.INTERRUPTED:
            self.stop = Stop.OPTIMAL
        elif self.stop is Stop.FINISHED and self.plain.stop not in (Stop.OPTIMAL, Stop.FINISHED):
            self.stop = self.plain.stop
        return Solution(
            tree=self.tree,
            objective=self.objective,
            bound=self.bound,
            stop=self.stop,
            seconds=time.perf_counter() - self.started,
            n_nodes=self.n_nodes,
            solver=SOLVER,
            version=_native.__version__,
            seed=self.seed,
            tolerance=self.tolerance,
            details={"over": "worst case", "off": self.off},
        )


class _BandRanks(NamedTuple):
    """Ranks of the lowest and highest readings (n_features, n_samples), most sensors off, number of labels."""

    low: NDArray[np.uint32]
    high: NDArray[np.uint32]
    n_off: int
    n_labels: int


@dataclass(frozen=True, slots=True, eq=False)
class _NativeDrift:
    """A problem and its bands as the core holds them."""

    of_problem: Problem
    of_bands: Bands
    off: int
    problem: _native.Problem
    bands: _BandRanks
    ranks: Ranks
    costs: IntegerCosts

    @classmethod
    def of(cls, problem: Problem, bands: Bands, off: int) -> "_NativeDrift":
        """Rank lowest, true and highest readings together."""
        n = problem.n_samples
        together = Ranks.of(np.vstack([bands.low, problem.features, bands.high]))
        low, true, high = (np.ascontiguousarray(together.ranks[:, k * n : (k + 1) * n]) for k in range(3))
        ranks, costs = Ranks(_native.RankTable(true), together.values), integer_costs(problem, None)
        row = _BandRanks(low, high, min(off, len(problem.sensors)), problem.n_classes)
        return cls(problem, bands, off, native_problem(problem, ranks, costs), row, ranks, costs)

    def incumbent(self, tree: Node) -> tuple[int, list[NodeRow]]:
        """Return a tree as the core takes it, with its cost there."""
        whole = without_empty_sides(tree, self.of_problem.features)
        rows = rows_from_tree(whole, self.ranks)
        return self.cost(tree_from_rows(rows, self.ranks)), rows

    def cost(self, tree: Node) -> int:
        """Return the worst case in whole numbers."""
        problem, costs = self.of_problem, self.costs
        sets = sets_off(problem, tree, self.of_bands, self.off)
        args = problem, tree, self.of_bands
        sums = [costs.weights @ most_paid(*args, gauges, costs.costs, costs.rows) for gauges in sets]
        return int(max(sums)) + costs.penalty * complexity(tree)
