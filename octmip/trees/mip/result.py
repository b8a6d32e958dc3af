"""The result of a run of HiGHS on a formulation, and the Solution that is made of it.

A tree is optimal only when its objective, recounted in the problem's own units, is met by a bound that holds there:
HiGHS's, through `octmip.trees.mip.highs.claims` and `octmip.trees.mip.prices`, or one given from elsewhere. All
arithmetic between the two is in fractions. Otherwise the run ends with the limit that was reached, or as
`Stop.NUMERICS`.
"""

import math
from dataclasses import dataclass
from fractions import Fraction

from octmip.trees.answer.solution import Solution, Stop, relative_gap
from octmip.trees.encoding.costs import rounded_down
from octmip.trees.mip.highs.highs import VERSION
from octmip.trees.mip.prices import Prices
from octmip.trees.mip.rows import Rows
from octmip.trees.nodes.tree import Node
from octmip.trees.question.problem import Problem


@dataclass(slots=True, eq=False)
class Known:
    """The best tree, the prices and the empty model that a formulation is built from, beside the problem.

    Attributes
    ----------
    tree
        the best tree known, by which a formulation may leave out what cannot be better; one that is met while the
        model is built takes its place (`better`).
    objective
        of it.
    prices
        what is to be minimised.
    rows
        the empty model to build in; it checks the limits.
    """

    tree: Node
    objective: float
    prices: Prices
    rows: Rows

    def better(self, problem: Problem, tree: Node) -> None:
        """Take a tree that is better than the best one."""
        if (objective := problem.objective(tree)) < self.objective:
            self.tree, self.objective = tree, objective


@dataclass(slots=True, eq=False)
class RunResult:
    """The best tree, bound and details of a run; grows while the run goes on.

    Attributes
    ----------
    known
        what the model was built from.
    tree
        the best one.
    stop
        why HiGHS ended.
    details
        of the Solution.
    n_nodes
        of HiGHS's tree.
    price_bound
        no tree of the model is priced below it.
    refuted
        why HiGHS is not believed; "" if it is.
    is_outside
        whether the best tree is none of the model, which holds the mu-separated trees only.
    """

    known: Known
    tree: Node
    stop: Stop
    details: dict[str, object]
    n_nodes: int = 0
    price_bound: int = 0
    refuted: str = ""
    is_outside: bool = False

    def better(self, problem: Problem, tree: Node) -> None:
        """Take a tree that is better than the best one."""
        if problem.objective(tree) < problem.objective(self.tree):
            self.tree = tree


def solution_of(problem: Problem, result: RunResult, *, method: str, seed: int, seconds: float, gap: float) -> Solution:
    """Return the Solution that follows from the result of a run.

    Parameters
    ----------
    method, seed
        of the run, to be named.
    seconds
        that it took.
    gap
        the relative gap that was asked for.
    """
    objective = problem.objective(result.tree)
    tolerance = _tolerance(problem, result.known.prices, objective)
    proven = _believed_bound(problem, result)
    if result.is_outside and proven > Fraction(objective):
        result.details |= _better_outside(str(result.details["scope"]), rounded_down(proven), objective)
    bound = min(Fraction(math.ceil(proven)) if problem.has_integer_costs else proven, Fraction(objective))
    stop = result.stop
    if bound >= Fraction(objective) - Fraction(tolerance):
        stop = Stop.OPTIMAL
    elif result.refuted:
        stop, result.details["numerics"] = Stop.NUMERICS, result.refuted
    elif stop is Stop.OPTIMAL:
        is_within_gap = 0 < gap >= relative_gap(objective, float(bound))
        stop = Stop.GAP if is_within_gap else Stop.NUMERICS
    return Solution(
        tree=result.tree,
        objective=objective,
        bound=rounded_down(bound),
        stop=stop,
        seconds=seconds,
        n_nodes=result.n_nodes,
        solver=method,
        version=f"HiGHS {VERSION}",
        seed=seed,
        tolerance=tolerance,
        details=result.details | normalised(problem, objective),
    )


def _believed_bound(problem: Problem, result: RunResult) -> Fraction:
    """Return the bound of a run in the problem's units; 0, which always holds, when a known tree contradicts it.

    A tree that the model leaves out (OCT-H's narrow bands) contradicts nothing: the bound is one of the trees of the
    model, and may lie above it.
    """
    prices = result.known.prices
    cheapest = min(prices.of_tree(problem, tree) for tree in (result.tree, result.known.tree))
    if result.price_bound > cheapest and not result.is_outside:
        result.refuted = result.refuted or (
            f"HiGHS claims that no tree of its model is priced below {result.price_bound} but one of "
            f"{cheapest} is known"
        )
        return Fraction(0)
    return max(prices.lower_bound(result.price_bound), Fraction(0))


def _better_outside(scope: str, proven: float, objective: float) -> dict[str, object]:
    """Return the details of a run whose best tree is none of the trees that its bound speaks about."""
    words = f"none of them costs less than {proven:.6g}; the tree found, of {objective:.6g}, is a better one outside"
    return {"scope": f"{scope} ({words})", "bound_in_scope": proven}


def _tolerance(problem: Problem, prices: Prices, objective: float) -> float:
    """Return the gap that rounded prices may leave between bound and objective; 0 if that would prove nothing."""
    if problem.has_integer_costs:
        return 0.0
    tolerance = float(prices.above + prices.below) * (1 + 1e-9) + 4e-16 * objective
    return tolerance if tolerance < problem.least_saving else 0.0


def normalised(problem: Problem, objective: float) -> dict[str, object]:
    """Return Bertsimas & Dunn's form of an objective: divided by the baseline, with alpha = leaf_penalty / baseline."""
    baseline = problem.baseline
    if baseline == 0:
        return {"baseline": 0.0, "alpha": None, "normalised_objective": None}
    return {
        "baseline": baseline,
        "alpha": problem.shape.leaf_penalty / baseline,
        "normalised_objective": objective / baseline,
    }
