"""Branch and bound over thresholds for regression trees: a thin wrapper of the native core.

The core counts ranks and scaled targets (see `octmip.trees.regression.grid`); the algorithm, its bounds and their
proofs are in docs/theory/regression.md. Where the grid is too coarse for the tree that is found, the search is done
again on the finer one that its objective allows. With a sensor budget the trees are parted by the sensors that they may
read: a set of trees is solved without the budget, and parted by a sensor of its best tree where that costs too much.
"""

import heapq
import math
import time
from dataclasses import dataclass, field
from fractions import Fraction
from itertools import count

from octmip.errors import ProblemError
from octmip.input.files import check_writable
from octmip.trees import _native
from octmip.trees.answer.certificate import checked_incumbent
from octmip.trees.answer.solution import (
    Limits,
    Progress,
    ProgressCallback,
    Solution,
    Stop,
    closing_tolerance,
    relative_gap,
)
from octmip.trees.encoding import Ranks, centred_tree
from octmip.trees.encoding.costs import rounded_down
from octmip.trees.evidence.regression_log import write_proof
from octmip.trees.methods.native_call import check_threads, logged, native_progress
from octmip.trees.methods.options import ExactOptions
from octmip.trees.nodes.tree import Node
from octmip.trees.question.problem import Problem
from octmip.trees.regression.grid import Grid

SOLVER = "exact"
PARTS = 2.0**50
"""The core reports progress in so many parts of the cost of the best leaf."""


def exact_regression(
    problem: Problem,
    *,
    limits: Limits = Limits(),  # noqa: B008 - frozen
    incumbent: Node | Solution | None = None,
    seed: int = 0,
    n_jobs: int = 1,
    progress: ProgressCallback | None = None,
    options: ExactOptions = ExactOptions(),  # noqa: B008 (frozen)
) -> Solution:
    """Return the best axis-aligned regression tree of a problem and the proof's bound.

    Parameters
    ----------
    problem
        with one feature in a split and ``leaf_model="constant"``.
    limits
        seconds, relative gap, nodes (evaluated cuts).
    incumbent
        a tree of the problem to start from.
    seed
        without effect: nothing is random.
    n_jobs
        threads, from depth 3 on. Cost, bound and tree of a finished search do not depend on it.
    progress
        called with a `Progress` about every 50 ms.
    options
        another search writes the proof's log, in the checker's whole numbers and several times as long; limits do not
        hold for it. The solution's bound is what the log proves.

    Raises
    ------
    ProblemError
        the problem asks for hyperplanes or linear leaves, or the incumbent is not one of its trees.
    ProofError
        the proof was interrupted, or the log cannot be written; the error holds the solution.
    """
    if not problem.is_provable:
        raise ProblemError(
            "the exact core finds axis-aligned regression trees with constant leaves but split is "
            f"{problem.shape.split!r} and leaf_model {problem.shape.leaf_model!r}; use method 'search'"
        )
    check_threads(n_jobs)
    search, proof = _Search(problem, limits, n_jobs, progress), options.proof
    search.keep(checked_incumbent(problem, incumbent))
    if proof is not None:
        check_writable(proof)
    search.search()
    assert search.tree is not None
    if proof is not None:
        with logged(proof, search.stop, lambda: search.solution(seed)):
            search.proven = write_proof(proof, problem, search.to_prove)
    return search.solution(seed)


@dataclass(frozen=True, slots=True, order=True)
class _Part:
    """Trees that may read the sensors not banned, as far as the budget allows beside those held."""

    bound: float
    number: int
    held: frozenset[int] = field(compare=False)
    banned: frozenset[int] = field(compare=False)


@dataclass(slots=True)
class _Search:
    """A search: the best tree, the bound, and what is left of the limits."""

    problem: Problem
    limits: Limits
    n_jobs: int
    progress: ProgressCallback | None
    started: float = field(default_factory=lambda: time.perf_counter())
    tree: Node | None = None
    objective: float = math.inf
    room: float = math.inf  # what the best tree costs on the grid
    bound: float = 0.0  # in the problem's units
    proven: float = math.inf  # by the log, where one was written
    n_cuts: int = 0
    stop: Stop = Stop.OPTIMAL
    ranks: Ranks = field(init=False)
    grid: Grid = field(init=False)
    leaf: float = field(init=False)

    def __post_init__(self) -> None:
        self.ranks = Ranks.of(self.problem.samples.features)
        self.grid = Grid.of(self.problem, self.problem.baseline)
        self.leaf = self.grid.leaf

    def keep(self, tree: Node | None) -> None:
        """Take up a tree that is better than the best so far."""
        if tree is None:
            return
        exact = self.problem.exact_objective(tree)
        if float(exact) < self.objective:
            self.tree, self.objective, self.room = tree, float(exact), self.grid.room(exact)

    def search(self) -> None:
        """Search on finer and finer grids, until the best tree is proven or a limit is reached."""
        self._search_parts()
        while self.stop is Stop.OPTIMAL and self.tolerance(self.bound) < 0:
            finer = Grid.of(self.problem, self.objective)
            if finer.span > self.grid.span / 2:
                break
            assert self.tree is not None
            self.grid, self.leaf = finer, finer.leaf
            self.room = finer.room(self.problem.exact_objective(self.tree))
            self._search_parts()

    def tolerance(self, bound: float) -> float:
        """Return the tolerance of a bound, -1 where it proves nothing of the tree."""
        return closing_tolerance(self.objective, bound, self.problem.least_saving_from(self.objective))

    def _search_parts(self) -> None:
        """Search the parts of the trees, the least bound first, until no open one may hold a better tree."""
        numbers = count()
        open_parts = [_Part(0.0, next(numbers), frozenset(), frozenset())]
        closed = self.room  # least bound of the parts that are done with
        while open_parts and open_parts[0].bound < self.room:
            part = heapq.heappop(open_parts)
            tree, bound = self._solve_part(part)
            extra = None if tree is None else self._sensor_beyond(tree, part)
            if extra is None:
                self.keep(tree)
            if extra is None or self.stop is not Stop.OPTIMAL:
                closed = min(closed, max(bound, part.bound))
            if self.stop is not Stop.OPTIMAL:
                break
            if extra is not None:
                for held, banned in (({extra}, set()), (set(), {extra})):
                    open_parts.append(_Part(bound, next(numbers), part.held | held, part.banned | banned))
                heapq.heapify(open_parts)
        least = min([closed, *(part.bound for part in open_parts)])
        self.bound = max(self.bound, self.grid.lower(least))
        if self.tree is None:
            self.keep(self.problem.best_leaf())

    def _sensor_beyond(self, tree: Node, part: _Part) -> int | None:
        """Return a sensor that the tree reads and the part does not hold, if the tree is over the budget."""
        shape = self.problem.shape
        if shape.sensor_cost_of(tree) <= shape.sensor_limit:
            return None
        used = {shape.sensors.index(name) for name in shape.sensors_used(tree)} - part.held
        return max(used, key=lambda sensor: (shape.sensor_costs[sensor], -sensor))

    def _solve_part(self, part: _Part) -> tuple[Node | None, float]:
        """Return the best tree of a part that costs less than the best so far, if there is one, and the bound."""
        grid, problem = self.grid, self.problem
        before = Progress(time.perf_counter() - self.started, self.objective, -math.inf, self.n_cuts)
        found = _native.regression(
            None if math.isinf(self.room) else self.room,
            self.limits.remaining(self.started, self.n_cuts),
            self.n_jobs,
            native_progress(self.progress, lambda whole: whole / PARTS * self.leaf, before),
            ranks=self.ranks.ranks,
            n_ranks=list(self.ranks.n_values),
            targets=grid.targets,
            weights=grid.weights,
            squares=grid.squares,
            grain=grid.grain,
            slopes=problem.number_loss.slopes,
            penalty=grid.penalty,
            depth=problem.shape.depth,
            leaf_size=problem.shape.leaf_size,
            allowed=self._allowed(part),
        )
        self.n_cuts += found.n_nodes
        self.stop = Stop(found.stop)
        if found.rows is None:
            return None, found.bound
        tree = centred_tree(found.rows, self.ranks, problem.samples.features)
        return problem.with_best_leaves(tree), found.bound

    def _allowed(self, part: _Part) -> list[bool]:
        shape = self.problem.shape
        costs = shape.sensor_costs
        left = shape.sensor_limit - math.fsum(costs[sensor] for sensor in part.held)
        is_free = [s in part.held or (s not in part.banned and costs[s] <= left) for s in range(len(costs))]
        return [is_free[s] and shape.is_allowed((f,)) for f, s in enumerate(shape.sensor_index.tolist())]

    @property
    def to_prove(self) -> Fraction:
        """What a log is to prove: the tree's objective if the search ended, else the bound."""
        assert self.tree is not None
        exact = self.problem.exact_objective(self.tree)
        return exact if self.stop is Stop.OPTIMAL else min(exact, Fraction(self.bound))

    def solution(self, seed: int) -> Solution:
        """Return the tree with its bound; what rounding alone keeps them apart by is the tolerance."""
        assert self.tree is not None
        bound = self.bound if math.isinf(self.proven) else self.proven
        bound = min(bound, rounded_down(self.problem.exact_objective(self.tree)))
        tolerance, stop = 0.0, self.stop
        if stop is Stop.OPTIMAL:
            tolerance = self.tolerance(bound)
            if tolerance < 0:
                tolerance, stop = 0.0, Stop.NUMERICS
        elif stop is Stop.GAP and relative_gap(self.objective, bound) > self.limits.gap:
            stop = Stop.NUMERICS
        seconds = time.perf_counter() - self.started
        return Solution(
            self.tree, self.objective, bound, stop, seconds, self.n_cuts, SOLVER, _native.__version__, seed, tolerance
        )
