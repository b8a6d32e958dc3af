"""Claims of HiGHS: the accuracy that a model needs, and the bound that may be believed.

A tree keeps every row and every integrality of its model exactly, at an objective that is a whole number of price
units (`octmip.trees.mip.prices`). So HiGHS's bound B is false of a tree priced T < B only if HiGHS cut that tree off.
Kept tolerances leave two ways to do that:

* A node is left out because its relaxation is no better than the incumbent, less the absolute gap g.
* The value of a relaxation is too high. HiGHS reports c'x of a basis whose reduced costs may have the wrong sign by up
  to the dual tolerance t. Let d_j be the reduced cost of column or row activity j between l_j and u_j. Weak duality,
  sum_j min(d_j l_j, d_j u_j) <= the true value, holds for any multipliers; the basis counts d_j at the end that it sits
  at, which exceeds the minimum by at most t (u_j - l_j) if the sign of d_j is wrong, and by nothing if it is right. So
  the reported value is too high by  e = t * sum_j (u_j - l_j)  at most, rows of equality left out (their multiplier has
  no sign). A primal infeasibility does not enter: a column or row in the basis has d_j = 0.

Hence T >= min(B, incumbent - g) - e, and T is whole, so T >= ceil of that. With g = 1 - 2 e - `ROUNDING` nothing is
lost to the gap as long as e < 1/2; t is chosen for that, down to HiGHS's finest.

This assumes that HiGHS keeps its tolerances. Where a known tree contradicts the bound, it has not, and nothing of the
bound is believed.
"""

import math
from dataclasses import dataclass

from octmip.trees.mip.highs.highs import Outcome
from octmip.trees.mip.prices import Prices
from octmip.trees.mip.rows import Rows

ROUNDING = 1e-3  # of an incumbent's objective in HiGHS, beside whole prices
LARGEST_DUAL, SMALLEST_DUAL = 1e-7, 1e-10  # HiGHS's default, and the finest it takes
SMALLEST_PRIMAL = 1e-9
COARSEST_DUAL = 1e-6  # among the defaults of HiGHS, SCIP, CBC, GLPK, Gurobi and CPLEX
MOST_ERROR = 0.05  # of a relaxation's value, in units of price, that the dual tolerance is chosen for
MOST_LEAK = 0.2  # what a big M lets through at an integrality that HiGHS takes for whole


@dataclass(frozen=True, slots=True)
class Accuracy:
    """The accuracy with which HiGHS must compute.

    Attributes
    ----------
    tolerance
        of feasibility and integrality.
    dual_tolerance
        of reduced costs.
    error
        by how much a relaxation's value may be too high, in units of price.
    """

    tolerance: float
    dual_tolerance: float
    error: float

    @property
    def absolute_gap(self) -> float:
        """The gap at which HiGHS may stop."""
        return max(1 - 2 * self.error - ROUNDING, ROUNDING)

    def bound(self, outcome: Outcome) -> int:
        """Return the price that no tree of the model lies below; 0 if HiGHS proves nothing."""
        incumbent = min(outcome.objective, outcome.claimed)  # by what it claims, HiGHS leaves out nodes
        reached = min(outcome.bound, incumbent - self.absolute_gap) - self.error
        return max(math.ceil(reached), 0) if math.isfinite(reached) else 0


def foreign_bound(rows: Rows, prices: Prices, bound: float, dual_tolerance: float, further: float) -> int:
    """Return the price that no tree of a model lies below, by the bound of a solver that kept a dual tolerance.

    `further` is the sum of the ranges of rows that are not the model's own.
    """
    reached = bound - dual_tolerance * (_ranges(rows, prices) + further) - ROUNDING
    return max(math.ceil(reached), 0) if math.isfinite(reached) else 0


def accuracy(rows: Rows, prices: Prices, tolerance: float) -> Accuracy:
    """Return the accuracy with which HiGHS must compute on a model, at least as fine as `tolerance`."""
    ranges = _ranges(rows, prices)
    dual = min(max(MOST_ERROR / ranges, SMALLEST_DUAL), LARGEST_DUAL)
    leak = min(tolerance, max(MOST_LEAK / max(prices.worst, 1.0), SMALLEST_PRIMAL))
    return Accuracy(leak, dual, dual * ranges)


def _ranges(rows: Rows, prices: Prices) -> float:
    """Return the sum of the ranges of all columns and of the activities of all rows that are no equalities."""
    upper = rows.upper
    for letter, most in _most(prices).items():
        if letter in rows.families:
            upper[rows.families[letter][0]] = most
    columns = upper - rows.lower
    low, high = rows.row_bounds
    activities = abs(rows.matrix()) @ columns
    return float(columns.sum() + activities[low < high].sum())


def _most(prices: Prices) -> dict[str, float]:
    """Return, by letter, the largest value of the columns that have no bound of their own."""
    weight = float(prices.weights.sum())
    return {"N_t": weight, "N_kt": weight, "L": prices.worst}
