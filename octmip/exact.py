"""Branch and bound over thresholds: provably optimal axis-aligned trees. A thin wrapper of the native core.

The core counts ranks and integers (see `octmip.encoding`); the algorithm, its bounds and their proofs are in
docs/theory/exact.md. Categorical features: one column of 0/1 for each category, all columns reading one sensor
(`sensor_of_feature`), so that a split asks "is it this category?" and the sensor is paid for once.
"""

import math
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from octmip import _native
from octmip.encoding import (
    CAPACITY,
    IntegerCosts,
    NodeRow,
    Ranks,
    closing_tolerance,
    integer_costs,
    native_problem,
    rank_features,
    rows_from_tree,
    tree_from_rows,
)
from octmip.errors import ProblemError, SolverError
from octmip.problem import Problem
from octmip.proof import log_header
from octmip.solution import Limits, Progress, ProgressCallback, Solution, Stop
from octmip.tree import (
    HyperplaneSplit,
    Leaf,
    Node,
    centred,
    depth,
    goes_left,
    leaf_index,
    leaves,
    n_splits,
    predict,
    splits,
    without_empty_sides,
)

SOLVER = "exact"
MOST_WHOLE = 2**62  # a worse tree is no start for the core
UNBROKEN = {"splits": "not broken", "sensors": "not broken", "margin": "thresholds centred in their nodes"}


def branch_and_bound(
    problem: Problem,
    *,
    limits: Limits = Limits(),  # noqa: B008 - frozen
    incumbent: Node | Solution | None = None,
    seed: int = 0,
    n_jobs: int = 1,
    progress: ProgressCallback | None = None,
    proof: str | Path | None = None,
    break_ties: bool = False,
    _off: Sequence[str] = (),
) -> Solution:
    """Return the best axis-aligned tree of a problem and the proof's bound.

    Parameters:
        problem: with ``split="axis"``; any weights, costs, depth, leaf size, penalty.
        limits: seconds, relative gap, nodes (evaluated cuts), bytes of the core's own tables.
        incumbent: a feasible tree to start from; a good one shortens the proof (`octmip.solver.solve` looks for one).
        seed: of the start's random choices.
        n_jobs: threads. Cost, bound and tree of a finished search do not depend on it.
        progress: called with a `Progress` about every 50 ms.
        proof: file for a log that `octmip.proof.check_proof` verifies; it takes a second search, about as long.
        break_ties: among the optimal trees return one of fewest splits, of those one of fewest sensors, each proven by
            more searches; `details["ties_broken"]` says what was. Thresholds are centred in any case.
        _off: names of prunes to do without (`_native.prunes()`), for tests.

    Raises:
        ProblemError: the problem asks for hyperplanes, or the incumbent is not one of its trees.
        SolverError: the proof was interrupted before it could be written.
    """
    started = time.perf_counter()
    _check(problem, n_jobs)
    start = None if incumbent is None else _feasible(problem, incumbent)
    run = _Run(problem, limits, n_jobs, progress, _off, started)
    run.search(start)
    ties = dict(UNBROKEN)
    if break_ties and run.stop is Stop.OPTIMAL:
        ties = run.break_ties()
    if proof is not None:
        _write_proof(problem, *run.proven, Path(proof))
    assert run.tree is not None
    return Solution(
        tree=run.tree,
        objective=run.objective,
        bound=run.bound,
        stop=run.stop,
        seconds=time.perf_counter() - started,
        n_nodes=run.n_nodes,
        solver=SOLVER,
        version=_native.__version__,
        seed=seed,
        tolerance=run.tolerance,
        details={"ties_broken": ties},
    )


@dataclass(slots=True)
class _Run:
    """A search, and again on a finer grid while rounding alone keeps the bound from the tree."""

    problem: Problem
    limits: Limits
    n_jobs: int
    progress: ProgressCallback | None
    off: Sequence[str]
    started: float
    ranks: Ranks = field(init=False)
    tree: Node | None = None
    objective: float = math.inf
    bound: float = -math.inf
    stop: Stop = Stop.INTERRUPTED
    tolerance: float = 0.0
    n_nodes: int = 0
    proven: tuple[_native.Problem, IntegerCosts, int] = field(init=False)  # of the best bound

    def __post_init__(self) -> None:
        self.ranks = rank_features(self.problem)

    def search(self, start: Node | None) -> None:
        """Search until the bound meets the tree, or no grid of whole numbers is finer."""
        costs: IntegerCosts | None = None
        self._keep(start)
        while True:
            finer = integer_costs(self.problem, self.tree)
            if costs is not None and finer.exponent <= costs.exponent:
                self.stop = Stop.NUMERICS
                return
            costs = finer
            self.stop = self._search_grid(costs)
            if self.stop is not Stop.OPTIMAL or self._is_proven(costs):
                return

    def _search_grid(self, costs: IntegerCosts) -> Stop:
        native = native_problem(self.problem, self.ranks, costs)
        spent = time.perf_counter() - self.started if self.n_nodes else 0.0
        limits = (self.limits.seconds - spent, self.limits.gap, self.limits.nodes - self.n_nodes, self.limits.memory)
        first = None if self.tree is None else (self._known(costs), rows_from_tree(self.tree, self.ranks))
        notify = None if self.progress is None else self._notify(costs)
        rows, _, bound, stop, n_nodes = _native.branch_and_bound(
            native, limits, self.n_jobs, first, list(self.off), notify
        )
        self.n_nodes += n_nodes
        lower = costs.value(bound)
        if lower > self.bound:
            self.bound, self.proven = lower, (native, costs, bound)
        found = centred(tree_from_rows(rows, self.ranks), self.problem.features)
        self._keep(found)
        if costs.is_rounded:
            # Samples too light for the grid still have labels; equal in float64, the grid's own are the better ones.
            self._keep(_relabelled(self.problem, found), least=math.ulp(0.0))
        return Stop(stop)

    def _keep(self, tree: Node | None, least: float = 0.0) -> None:
        """Take up a tree that is better by so much, by the true costs: rounded ones can rank two the wrong way."""
        if tree is None:
            return
        objective = self.problem.objective_of(tree, predict(tree, self.problem.features))
        if math.isinf(self.objective) or self.objective - objective >= least:
            self.tree, self.objective = tree, objective

    def _known(self, costs: IntegerCosts) -> int:
        assert self.tree is not None
        return min(costs.whole_objective(self.problem, self.tree), MOST_WHOLE)

    def _is_proven(self, costs: IntegerCosts) -> bool:
        """Whether a search to its end proves the tree optimal: what rounding may hide is less than a sample's worth."""
        if not costs.is_rounded:
            return True
        tolerance = closing_tolerance(self.problem, self.objective, self.bound)
        self.tolerance = max(0.0, tolerance)
        return tolerance >= 0

    def _notify(self, costs: IntegerCosts) -> Callable[[float, int, int, int], None]:
        before, callback = time.perf_counter() - self.started if self.n_nodes else 0.0, self.progress
        assert callback is not None

        def report(seconds: float, objective: int, bound: int, n_nodes: int) -> None:
            found, lower = min(self.objective, costs.value(objective)), max(self.bound, costs.value(bound))
            callback(Progress(before + seconds, found, lower, self.n_nodes + n_nodes))

        return report

    def break_ties(self) -> dict[str, str]:
        """Replace the tree by a smaller one that costs the same, and return what is proven of it."""
        assert self.tree is not None
        _, costs, _ = self.proven
        effort = _Effort(self.started + self.limits.seconds, self.limits, self.n_jobs)
        rows, ties = _break_ties(self.problem, self.ranks, costs, rows_from_tree(self.tree, self.ranks), effort)
        smaller = centred(tree_from_rows(rows, self.ranks), self.problem.features)
        self._keep(smaller)
        return ties if self.tree is smaller else dict(UNBROKEN)


def _relabelled(problem: Problem, tree: Node, rows: NDArray[np.int64] | None = None) -> Node:
    """Return the tree with leaves labelled by the true costs: on the grid some may have none."""
    rows = np.arange(problem.n_samples) if rows is None else rows
    if isinstance(tree, Leaf):
        return Leaf(int(problem.class_costs(rows).argmin()))
    left = goes_left(tree, problem.features[rows])
    sides = [_relabelled(problem, side, rows[part]) for side, part in ((tree.left, left), (tree.right, ~left))]
    return replace(tree, left=sides[0], right=sides[1])


def _check(problem: Problem, n_jobs: int) -> None:
    if problem.split != "axis":
        raise ProblemError(
            "the exact core finds axis-aligned trees but split is 'hyperplane'; use method 'search' or 'oct_h'"
        )
    if n_jobs < 1:
        raise ProblemError(f"n_jobs is {n_jobs}; expected 1 or more")


def _feasible(problem: Problem, incumbent: Node | Solution) -> Node:
    """Return the incumbent's tree without idle splits; refuse one that is no tree of the problem."""
    given = incumbent.tree if isinstance(incumbent, Solution) else incumbent
    if given is None:
        raise ProblemError("the incumbent solution holds no tree; leave it out or give a tree")
    if any(isinstance(split, HyperplaneSplit) for split in splits(given)):
        raise ProblemError("the incumbent has a split over a hyperplane; the exact core needs an axis-aligned tree")
    forbidden = problem.first_forbidden_split(given)
    if forbidden:
        raise ProblemError(f"the incumbent is not a tree of this problem: {forbidden}")
    largest = max(leaf.label for leaf in leaves(given))
    if largest >= problem.n_classes:
        raise ProblemError(f"the incumbent predicts class {largest} but the problem has {problem.n_classes} classes")
    tree = without_empty_sides(given, problem.features)
    if depth(tree) > problem.depth:
        raise ProblemError(f"the incumbent has depth {depth(tree)} but the problem allows {problem.depth}")
    sizes = np.bincount(leaf_index(tree, problem.features), minlength=len(leaves(tree)))
    if n_splits(tree) and sizes.min() < problem.leaf_size:
        raise ProblemError(f"a leaf of the incumbent holds {sizes.min()} samples but leaf_size is {problem.leaf_size}")
    if problem.sensor_cost_of(tree) > problem.sensor_limit:
        raise ProblemError(
            f"the incumbent reads sensors of cost {problem.sensor_cost_of(tree)}; the budget is {problem.sensor_budget}"
        )
    return tree


@dataclass(frozen=True, slots=True)
class _Effort:
    """What is left for breaking ties: until when, and the limits of each search."""

    until: float
    limits: Limits
    n_jobs: int

    def search(self, native: _native.Problem, first: tuple[int, list[NodeRow]]) -> tuple[list[NodeRow], int, bool]:
        """Return table and cost of the cheapest tree (`first` where none is cheaper), and whether that is proven."""
        values = (max(0.0, self.until - time.perf_counter()), 0.0, self.limits.nodes, self.limits.memory)
        rows, cost, _, stop, _ = _native.branch_and_bound(native, values, self.n_jobs, first)
        return rows, cost, stop == Stop.OPTIMAL


def _break_ties(
    problem: Problem, ranks: Ranks, costs: IntegerCosts, rows: list[NodeRow], effort: _Effort
) -> tuple[list[NodeRow], dict[str, str]]:
    """Return the table of an optimal tree of fewest splits, of those one of fewest sensors, and what is proven of it.

    Every cost is multiplied by more than the splits that a tree can have, and a split costs one more: the cheapest tree
    of that problem is a cheapest one of this, and has the fewest splits of those.
    """
    factor = min(2**problem.depth, problem.n_samples)
    finer = replace(costs, costs=costs.costs * factor, penalty=costs.penalty * factor + 1)
    largest = float(finer.weights.sum()) * float(finer.costs.max()) + finer.penalty * factor
    if largest >= CAPACITY:
        return rows, UNBROKEN | {"splits": "not broken: the costs are too fine to count splits beside them"}
    cost = finer.whole_objective(problem, tree_from_rows(rows, ranks))
    rows, cost, is_proven = effort.search(native_problem(problem, ranks, finer), (cost, rows))
    if not is_proven:
        return rows, UNBROKEN | {"splits": "fewer looked for, not proven"}
    rows, said = _fewest_sensors(problem, ranks, finer, (cost, rows), effort)
    return rows, UNBROKEN | {"splits": "fewest, proven", "sensors": said}


def _fewest_sensors(
    problem: Problem, ranks: Ranks, costs: IntegerCosts, best: tuple[int, list[NodeRow]], effort: _Effort
) -> tuple[list[NodeRow], str]:
    """Return the table of a tree no dearer than `best` that reads the fewest sensors, and what is proven of it.

    One sensor fewer at a time, as a budget, until no tree within it is as cheap: none of still fewer is, as cost never
    falls when sensors are taken away.
    """
    cost, rows = best
    is_bound = math.fsum(problem.sensor_costs) > problem.sensor_limit
    if is_bound and np.ptp(problem.sensor_costs) > 0:
        return rows, "not broken: a budget of sensors of different cost is kept"
    while n_sensors := len(problem.sensors_used(tree_from_rows(rows, ranks))):
        fewer = replace(problem, sensor_cost=[1.0] * len(problem.sensors), sensor_budget=float(n_sensors - 1))
        leaf: NodeRow = (0, 0, 0, 0, 0, 0, [], 0.0)
        # Stands for "a tree that costs one more": what comes back in its place is as cheap as `best`.
        found, least, is_proven = effort.search(native_problem(fewer, ranks, costs), (cost + 1, [leaf]))
        if least <= cost:
            rows = found
        elif is_proven:
            break
        else:
            return rows, "fewer looked for, not proven"
    return rows, "fewest, proven"


def _write_proof(problem: Problem, native: _native.Problem, costs: IntegerCosts, claim: int, path: Path) -> None:
    body = _native.prove(native, claim)
    if body is None:
        raise SolverError(f"the proof of the bound {costs.value(claim)} was interrupted; {path} is not written")
    header = log_header(problem, costs, claim)
    path.write_text(header + body + "end\n", encoding="ascii")
