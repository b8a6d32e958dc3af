"""A problem whose trees are counted, as the native core holds it: no cost is rounded, none is on the wrong side.

The bounds of the core may come from a coarser grid, rounded down (`octmip.trees.encoding.costs`); the costs that are
counted are whole numbers of one power of two, of 64 bits where every sum fits, else of 128.
"""

from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import numpy as np

from octmip.errors import ProblemError
from octmip.trees import _native
from octmip.trees.encoding import Ranks, integer_costs, native_problem, rank_features
from octmip.trees.encoding.costs import power_of_two, whole_exponent
from octmip.trees.nodes.tree import Node
from octmip.trees.question.problem import Problem

NARROW, WIDE = 2**61, 2**125


@dataclass(frozen=True, slots=True, eq=False)
class WholeProblem:
    """A problem in whole numbers of ``2**-exponent``.

    Attributes
    ----------
    native
        the problem whose trees the core counts.
    ranks
        of its features.
    exponent
        of the unit.
    most
        no tree costs more, in units.
    made_of
        the arguments of `whole_problem`, by which another process makes it again: the core's problem stays in its own.
    """

    native: _native.NearProblem
    ranks: Ranks
    exponent: int
    most: int
    made_of: tuple[Problem, Node, bool]

    def __reduce__(self) -> tuple[Any, ...]:
        return whole_problem, self.made_of

    def units(self, cost: Fraction) -> int:
        """Return the units in a cost, rounded down; at most `most`."""
        return min(self.most, int(cost * power_of_two(self.exponent) // 1))

    def cost(self, units: int) -> Fraction:
        """Return the cost of so many units."""
        return units * power_of_two(-self.exponent)


def whole_problem(problem: Problem, tree: Node, by_sets: bool) -> WholeProblem:
    """Return a problem in whole numbers, its bounds on a grid that fits trees about as good as `tree`.

    Raises
    ------
    ProblemError
        its costs span more than 125 binary digits, or there are more sensors than sets of them can be told apart by.
    """
    samples = problem.samples
    grid = integer_costs(problem, tree)
    weight_digits = whole_exponent(samples.weights)
    digits = [weight_digits + whole_exponent(problem.costs), whole_exponent(np.array([problem.shape.leaf_penalty]))]
    exponent = max(*digits, grid.exponent)
    weights = [int(Fraction(w) * power_of_two(weight_digits)) for w in samples.weights.tolist()]
    costs = [int(Fraction(c) * power_of_two(exponent - weight_digits)) for c in problem.costs.ravel().tolist()]
    penalty = int(Fraction(problem.shape.leaf_penalty) * power_of_two(exponent))
    most = sum(weights) * max(costs) + penalty * min(2**problem.shape.depth, samples.n_samples)
    if most >= WIDE:
        raise ProblemError(
            f"weights, costs and leaf_penalty span {most.bit_length()} binary digits, too many to count trees without "
            f"rounding; expected at most {WIDE.bit_length() - 1}; round them to fewer digits"
        )
    ranks = rank_features(problem)
    core = native_problem(problem, ranks, grid)
    exact = {
        "classes": samples.codes.tolist(),
        "weights": weights,
        "costs": costs,
        "n_labels": samples.n_classes,
        "penalty": penalty,
        "shift": exponent - grid.exponent,
    }
    above = [column for column in range(ranks.n_columns) if ranks.side(column) == "right"]
    try:
        native = _native.NearProblem(core, exact, above, most < NARROW, by_sets)
    except ValueError as error:
        raise ProblemError(
            f"trees cannot be told apart by the sensors that they read: {error}; use fewer features, or no budget"
        ) from error
    return WholeProblem(native, ranks, exponent, most, (problem, tree, by_sets))
