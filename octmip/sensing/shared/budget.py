"""Trees for several labels under one budget of sensors, each sensor paid for once.

A wing whose damage is read by one tree for each of its regions pays for a gauge once, however many trees read it. Each
label by itself would choose other gauges than all together do, and no split of the budget between labels knows of
gauges that serve two. Which sensors serve all best is found over sets of sensors:

exact    axis-aligned trees: branch and bound over sets, each label's tree by the exact core (see sensor_sets.py)
search   any trees: from the best baseline split, the labels find their trees again in turn, the others' sensors free;
         then each sensor is given up once and the turns are taken again

Both begin with the best baseline split (`octmip.sensing.shared.baseline_split`: the budget divided between the labels)
and keep the best trees met, so they are never worse than it.
"""

import math
import time
from collections.abc import Sequence
from dataclasses import replace
from typing import Literal

from octmip.errors import ProblemError
from octmip.sensing.shared.baseline_split import best_baseline_split
from octmip.sensing.shared.label_trees import JointTrees, LabelTrees
from octmip.sensing.shared.sensor_sets import Proof, SetSearch
from octmip.sensing.shared.solution import JointSolution, certify_joint, sensor_prices, weighted_sum
from octmip.trees._native import __version__
from octmip.trees.methods.options import NO_OPTIONS, Options
from octmip.trees.problem import Problem
from octmip.trees.registry import Run, refuse_numbers
from octmip.trees.solution import Limits, Solution, Stop
from octmip.trees.tree import Leaf, Node

JointMethod = Literal["auto", "exact", "search"]
EXACT_DEPTH = 3  # "auto" proves to this depth; a proof of one label takes a second there, and there are many


def shared_budget(
    problems: Sequence[Problem],
    budget: float,
    *,
    weights: Sequence[float] | None = None,
    method: JointMethod = "auto",
    limits: Limits = Limits(),  # noqa: B008 (frozen)
    seed: int = 0,
    n_jobs: int = 1,
    options: Options = NO_OPTIONS,
) -> JointSolution:
    """Return one tree for each problem, all within one budget of sensors, and the bound of their weighted sum.

    Parameters
    ----------
    problems
        one per label, without budgets of their own. Sensors of one name are one sensor and have one cost. Depth, kind
        of split, weights and costs may differ.
    budget
        of all sensors that some tree reads, each paid for once.
    weights
        of the labels' objectives in the sum; None: all 1.
    method
        "exact" (axis-aligned trees) proves; "search" does not; "auto" is exact to depth 3, else search.
    limits
        wall seconds, relative gap, nodes (sets of sensors) and memory of all together.
    seed, n_jobs, options
        of every solve; options are the method's own, for instance ``restarts`` of the search.

    Returns
    -------
    The joint solution; its `baseline_split` is the best split of the budget into one for each label, and the sum never
    lies above it.

    Raises
    ------
    ProblemError
        there is no problem, one has a budget of its own, a sensor has two costs, weights or method do
        not fit.
    SolverError
        a solver failed.
    """
    for problem in problems:
        refuse_numbers(problem, "shared_budget")
    shared, shares = _shared(problems, budget), _checked_weights(weights, len(problems))
    labels = LabelTrees(
        problems=shared,
        weights=shares,
        prices=sensor_prices(shared),
        run=Run(_chosen_method(shared, method), limits, seed, n_jobs, options),
        best=_leaves(shared, shares),
    )
    baseline = best_baseline_split(labels, budget)
    labels.alternate(labels.best.trees)
    proof = SetSearch(labels).run() if labels.run.method == "exact" else _search(labels)
    joint = JointSolution(
        problems=labels.problems,
        weights=labels.weights,
        solutions=tuple(_solution(labels, k, proof.own_bounds[k]) for k in range(len(labels.problems))),
        bound=proof.bound,
        stop=proof.stop,
        seconds=time.perf_counter() - labels.started,
        n_nodes=proof.n_nodes,
        baseline_split=baseline,
        tolerance=proof.tolerance,
    )
    certify_joint(joint)
    return joint


def _shared(problems: Sequence[Problem], budget: float) -> tuple[Problem, ...]:
    if not problems:
        raise ProblemError("problems is empty; expected one problem for each label; give one")
    budgeted = [k for k, problem in enumerate(problems) if problem.sensor_budget is not None]
    if budgeted:
        raise ProblemError(
            f"problems {budgeted} have a sensor_budget of their own; expected none, as the shared "
            "one holds for all; leave it out"
        )
    return tuple(replace(problem, sensor_budget=budget) for problem in problems)


def _leaves(problems: Sequence[Problem], weights: Sequence[float]) -> JointTrees:
    """Return the best trees without a sensor, which any others must beat."""
    trees = tuple(Leaf(int(problem.class_costs().argmin())) for problem in problems)
    return JointTrees(trees, weighted_sum(weights, (problem.baseline for problem in problems)))


def _checked_weights(weights: Sequence[float] | None, n_labels: int) -> tuple[float, ...]:
    shares = (1.0,) * n_labels if weights is None else tuple(float(weight) for weight in weights)
    if len(shares) != n_labels or not all(math.isfinite(share) and share >= 0 for share in shares) or not any(shares):
        raise ProblemError(
            f"weights is {weights}; expected {n_labels} finite numbers of 0 or more, not all 0: one for each problem"
        )
    return shares


def _chosen_method(problems: Sequence[Problem], method: str) -> Literal["exact", "search"]:
    is_axis = all(problem.split == "axis" for problem in problems)
    if method == "auto":
        return "exact" if is_axis and max(problem.depth for problem in problems) <= EXACT_DEPTH else "search"
    if method == "exact" and not is_axis:
        raise ProblemError("method is 'exact' but a problem asks for hyperplanes; use 'search', or split='axis'")
    if method not in ("exact", "search"):
        raise ProblemError(f"method is {method!r}; expected 'auto', 'exact' or 'search'")
    return "exact" if method == "exact" else "search"


def _search(labels: LabelTrees) -> Proof:
    """Improve the best trees: give up each sensor in turn, take turns again, until no sensor is worth giving up."""
    is_better = True
    while is_better and not labels.is_over:
        is_better = False
        for sensor in sorted(labels.sensors_of(labels.best.trees)):
            before = labels.best.objective
            labels.alternate(_without(labels, labels.best.trees, sensor))
            if labels.best.objective < before:
                is_better = True
                break
    is_free = labels.best.objective == 0
    stop = Stop.OPTIMAL if is_free else Stop.TIME if labels.is_over else Stop.FINISHED
    if labels.is_interrupted:
        stop = Stop.INTERRUPTED
    bound = 0.0 if is_free else -math.inf
    return Proof(bound, stop, 0, (bound,) * len(labels.problems), 0.0)


def _without(labels: LabelTrees, trees: Sequence[Node], sensor: str) -> tuple[Node, ...]:
    """Return the trees, those that read `sensor` found again without it; the others' sensors stay paid for."""
    kept = labels.sensors_of(trees) - {sensor}
    found = list(trees)
    for label, (problem, tree) in enumerate(zip(labels.problems, trees, strict=True)):
        if sensor in problem.sensors_used(tree):
            solution = labels.solve(label, kept, frozenset(labels.prices) - kept)
            found[label] = solution.tree if solution.tree is not None else labels.leaf(label)
    return tuple(found)


def _solution(labels: LabelTrees, label: int, own_bound: float) -> Solution:
    """Return a label's tree as a solution of its problem; its bound is one for this label alone."""
    problem, tree = labels.problems[label], labels.best.trees[label]
    objective = problem.objective(tree)
    return Solution(
        tree=tree,
        objective=objective,
        bound=min(own_bound, objective),
        stop=Stop.OPTIMAL if own_bound >= objective else Stop.FINISHED,
        seconds=time.perf_counter() - labels.started,
        n_nodes=0,
        solver="shared budget",
        version=__version__,
        seed=labels.run.seed,
    )
