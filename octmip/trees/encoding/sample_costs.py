"""A problem with costs of single samples as one of weighted samples with 0/1 costs, and its solution back.

Sample i pays ``p_ik = w_i c_ik`` for decision k. It becomes one row for each class k of weight
``W_ik = w_i (max_k c_ik - c_ik)`` above 0: a wrong row costs its weight, so label k costs the rows together

    sum_{l != k} W_il  =  (sum_l W_il - w_i max_l c_il)  +  p_ik

which is p_ik but for a number that no tree changes. W_ik is rounded to float64. With e_ik = p_ik - sum_{l != k} W_il in
fractions, base = sum_i min_k e_ik and spread = sum_i (max_k e_ik - min_k e_ik), every tree T has

    rows(T) + base  <=  true(T)  <=  rows(T) + base + spread

Source: Zadrozny, Langford & Abe (2003), Cost-sensitive learning by cost-proportionate example weighting, for two
classes; with more the sum over classes is the pairing of weights with 0/1 costs written out above.
"""

import math
from dataclasses import dataclass, replace
from fractions import Fraction

import numpy as np

from octmip.errors import ProblemError
from octmip.trees.answer.solution import Progress, ProgressCallback, Solution, Stop, is_tolerable
from octmip.trees.encoding.costs import rounded_down
from octmip.trees.question.losses import ClassCosts
from octmip.trees.question.problem import Problem

OF_ROWS = ("baseline", "alpha", "normalised_objective", "start", "bound_in_scope")
"""Details of a solution that speak of the weighted rows."""


@dataclass(frozen=True, slots=True, eq=False)
class WeightedRows:
    """A problem with costs of samples, and the same trees over weighted rows.

    Attributes
    ----------
    problem
        as it was asked.
    rows
        of 0/1 costs.
    base, spread
        see the module.
    """

    problem: Problem
    rows: Problem
    base: Fraction
    spread: Fraction

    def back(self, solution: Solution) -> Solution:
        """Return a solution over the rows as one of the problem: its tree recounted, its bound moved by the base."""
        problem = self.problem
        if solution.tree is None:
            return replace(solution, bound=self._bound(solution.bound))
        objective = problem.objective(solution.tree)
        bound = min(self._bound(solution.bound), objective)
        tolerance = 0.0
        if not problem.has_integer_costs:
            rounding = 4e-16 * (objective + solution.objective)
            tolerance = (solution.tolerance + float(self.spread)) * (1 + 1e-9) + rounding
            tolerance = tolerance if is_tolerable(tolerance, problem.least_saving) else 0.0
        stop = solution.stop
        if stop is Stop.OPTIMAL and bound < objective - tolerance:
            stop = Stop.NUMERICS
        details = {name: value for name, value in solution.details.items() if name not in OF_ROWS}
        return replace(solution, objective=objective, bound=bound, tolerance=tolerance, stop=stop, details=details)

    def _bound(self, bound: float) -> float:
        if math.isinf(bound):
            return bound
        exact = max(Fraction(bound) + self.base, Fraction(0))
        return float(math.ceil(exact)) if self.problem.has_integer_costs else rounded_down(exact)

    def progress(self, told: ProgressCallback | None) -> ProgressCallback | None:
        """Return a callback that is told of the rows and tells of the problem."""
        if told is None:
            return None

        def tell(state: Progress) -> None:
            told(replace(state, objective=state.objective + float(self.base), bound=state.bound + float(self.base)))

        return tell


def weighted_rows(problem: Problem) -> WeightedRows | None:
    """Return a problem with costs of samples over weighted rows; None where every decision costs the same.

    Raises
    ------
    ProblemError
        leaves have a least size, and a sample would count several times.
    """
    samples = problem.samples
    table = problem.cost_table
    weights = samples.weights[:, None] * (table.max(axis=1, keepdims=True) - table)
    if not weights.any():
        return None
    is_row = weights > 0
    is_row[~is_row.any(axis=1), 0] = True  # a sample without a preference counts in a leaf all the same
    if problem.shape.leaf_size > 1 and (is_row.sum(axis=1) > 1).any():
        raise ProblemError(
            f"leaf_size is {problem.shape.leaf_size} with costs of single samples and {samples.n_classes} "
            "decisions; expected leaf_size 1 or two decisions; leave leaf_size out, or solve octmip.model(problem)"
        )
    sample, label = np.nonzero(is_row)
    rows = problem.replace(
        features=samples.features[sample],
        targets=np.array(samples.class_names)[label],
        weights=weights[sample, label],
        loss=ClassCosts(),
    )
    return WeightedRows(problem, rows, *_base_and_spread(problem, weights.tolist()))


def _base_and_spread(problem: Problem, weights: list[list[float]]) -> tuple[Fraction, Fraction]:
    base = spread = Fraction(0)
    for weight, costs, row in zip(problem.samples.weights.tolist(), problem.cost_table.tolist(), weights, strict=True):
        each = [Fraction(one) for one in row]
        whole = sum(each, Fraction(0))
        errors = [Fraction(weight) * Fraction(cost) - whole + own for cost, own in zip(costs, each, strict=True)]
        base += min(errors)
        spread += max(errors) - min(errors)
    return base, spread
