"""The frontier of missed critical states against false alarms, over the cost of a failure, each point with its proof.

With two decisions a step model's objective is (failure_loss - caution) * missed + caution * false alarms. So the proven
bound of a point is a line in the plane of the two numbers that no tree of the same depth lies below, and the points are
those of the frontier's convex hull; between two of them no price of a failure prefers another tree.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

from numpy.typing import ArrayLike

from octmip.trees.answer.solution import Limits, Solution, Stop
from octmip.trees.methods.options import NO_OPTIONS, Options
from octmip.trees.nodes.tree import predict
from octmip.trees.question.problem import Problem
from octmip.trees.question.risk import ErrorRates, RiskModel
from octmip.trees.runs.registry import Method, Run
from octmip.trees.solver import solve_run


@dataclass(frozen=True, slots=True)
class RiskPoint:
    """One point: the model with its price of a failure, problem, solution, and the tree's error rates in training."""

    model: RiskModel
    problem: Problem
    solution: Solution
    rates: ErrorRates


def trace_risk_frontier(
    model: RiskModel,
    features: ArrayLike,
    losses: ArrayLike,
    failure_losses: Sequence[float],
    *,
    depth: int,
    method: Method = "auto",
    limits: Limits = Limits(),  # noqa: B008 (frozen)
    seed: int = 0,
    n_jobs: int = 1,
    options: Options = NO_OPTIONS,
    **asked: Any,
) -> list[RiskPoint]:
    """Return a point for each price of a failure, ascending; each search starts from the tree of the point before.

    Parameters
    ----------
    model
        its `failure_loss` is replaced.
    features
        (n_samples, n_features).
    losses
        (n_samples, n_regions) as fractions.
    failure_losses
        in the unit of `model.caution_losses`; twice the caution weighs both mistakes alike.
    depth
        of the trees.
    asked
        other options of `Problem`, as ``sensor_budget``.
    options
        the method's own.

    Raises
    ------
    ProblemError
        the model has more than two decisions, or it makes no problem.
    """
    run = Run(method, limits, seed, n_jobs, options)
    points: list[RiskPoint] = []
    for price in sorted(failure_losses):
        here = replace(model, failure_loss=price)
        problem = here.decision_problem(features, losses, depth=depth, **asked)
        known = points[-1].solution.tree if points else None
        solution = solve_run(problem, run, known)
        rates = here.rates(losses, predict(solution.tree, problem.samples.features))
        points.append(RiskPoint(here, problem, solution, rates))
        if solution.stop is Stop.INTERRUPTED:
            break
    return points
