"""Branch and bound over thresholds: provably optimal axis-aligned trees. A thin wrapper of the native core.

The core counts ranks and integers (see `octmip.encoding`); the algorithm, its bounds and their proofs are in
docs/theory/exact.md. Categorical features: one column of 0/1 for each category, all columns reading one sensor
(`sensor_of_feature`), so that a split asks "is it this category?" and the sensor is paid for once.
"""

import math
import time
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from octmip import _native
from octmip.encoding import (
    CAPACITY,
    IntegerCosts,
    NodeRow,
    Ranks,
    integer_costs,
    native_problem,
    rank_features,
    rows_from_tree,
    tree_from_rows,
)
from octmip.errors import ProblemError, SolverError
from octmip.problem import Problem
from octmip.proof import proof_header
from octmip.solution import Limits, Progress, ProgressCallback, Solution, Stop
from octmip.tree import (
    HyperplaneSplit,
    Node,
    centred,
    depth,
    leaf_index,
    leaves,
    n_splits,
    predict,
    splits,
    without_empty_sides,
)

SOLVER = "exact"
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
    ranks, costs = rank_features(problem), integer_costs(problem)

    def report(seconds: float, objective: int, bound: int, n_nodes: int) -> None:
        assert progress is not None
        progress(Progress(seconds, objective * costs.unit, bound * costs.unit, n_nodes))

    start = None if incumbent is None else _feasible(problem, incumbent)
    values = (limits.seconds, limits.gap, limits.nodes, limits.memory)
    native = native_problem(problem, ranks, costs)
    first = None if start is None else (_integer_objective(problem, start, costs), rows_from_tree(start, ranks))
    notify = None if progress is None else report
    rows, _, bound, stop, n_nodes = _native.branch_and_bound(native, values, n_jobs, first, list(_off), notify)
    ties = dict(UNBROKEN)
    if break_ties and stop == Stop.OPTIMAL:
        rows, ties = _break_ties(problem, ranks, costs, rows, _Effort(started + limits.seconds, limits, n_jobs))
    if proof is not None:
        _write_proof(problem, native, costs, bound, Path(proof))
    tree, objective = _better(problem, tree_from_rows(rows, ranks), start)
    if tree is start:
        ties = dict(UNBROKEN)
    return Solution(
        tree=tree,
        objective=objective,
        bound=bound * costs.unit,
        stop=Stop(stop),
        seconds=time.perf_counter() - started,
        n_nodes=n_nodes,
        solver=SOLVER,
        version=_native.__version__,
        seed=seed,
        tolerance=costs.tolerance,
        details={"ties_broken": ties},
    )


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
    cost = _integer_objective(problem, tree_from_rows(rows, ranks), finer)
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
        raise SolverError(f"the proof of the bound {claim * costs.unit} was interrupted; {path} is not written")
    header = proof_header(problem, costs.weight_unit, costs.unit / costs.weight_unit, claim)
    path.write_text(header + body + "end\n", encoding="ascii")


def _integer_objective(problem: Problem, tree: Node, costs: IntegerCosts) -> int:
    predicted = predict(tree, problem.features)
    paid = costs.weights * costs.costs[problem.codes, predicted]
    return int(paid.sum()) + costs.penalty * n_splits(tree)


def _better(problem: Problem, found: Node, start: Node | None) -> tuple[Node, float]:
    """Return the cheaper of two trees by the true costs: rounded ones can rank two trees the wrong way round."""
    tree = centred(found, problem.features)
    objective = problem.objective_of(tree, predict(tree, problem.features))
    if start is not None:
        known = problem.objective_of(start, predict(start, problem.features))
        if known < objective:
            return start, known
    return tree, objective
