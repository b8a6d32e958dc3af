"""Certificates of regression trees: a solution's claims, recounted in exact rational arithmetic. Imports no solver."""

import math
import sys
from dataclasses import dataclass
from fractions import Fraction

import numpy as np

from octmip.errors import CertificateError, ProblemError
from octmip.regression.problem import RegressionProblem
from octmip.solution import Solution, Stop, is_tolerable
from octmip.tree import (
    HyperplaneSplit,
    Leaf,
    Node,
    complexity,
    depth,
    leaf_index,
    leaves,
    n_splits,
    predict_values,
    splits,
)


@dataclass(frozen=True, slots=True)
class RegressionCertificate:
    """The figures of a regression tree, recounted sample by sample from the tree alone, nothing rounded on the way.

    Attributes
    ----------
    objective
        weighted error plus the prices of the splits, rounded once.
    normalised_objective
        objective divided by that of the best leaf; NaN where that is 0.
    mae, rmse
        weighted mean absolute error and root of the weighted mean squared error, whichever the loss was.
    n_splits, depth
        of the tree.
    sensors, sensor_cost
        that it reads.
    bound, gap
        the solution's bound, consistent with the objective; whether it is a true bound is its solver's claim.
    scope
        the trees that the bound speaks of.
    """

    objective: float
    normalised_objective: float
    mae: float
    rmse: float
    n_splits: int
    depth: int
    sensors: tuple[str, ...]
    sensor_cost: float
    bound: float
    gap: float
    scope: str


def certify_regression(problem: RegressionProblem, solution: Solution) -> RegressionCertificate:
    """Recompute what a solution claims and return it as a certificate.

    Raises
    ------
    CertificateError
        the tree breaks a limit of the problem, or objective, bound or stop are not what they say.
    """
    tree = solution.tree
    if tree is None:
        raise CertificateError(f"{solution.solver} found no tree (stop: {solution.stop}); there is nothing to certify")
    check_tree(problem, tree)
    exact = problem.exact_error(tree) + Fraction(problem.leaf_penalty) * complexity(tree)
    if exact > Fraction(sys.float_info.max):
        raise CertificateError(
            f"the tree of {solution.solver} errs on the {problem.n_samples} samples by more than float64 holds; "
            "expected predictions near the targets; tree and data do not belong together or one was changed"
        )
    baseline = problem.baseline
    _check_claims(problem, solution, exact, baseline)
    misses = np.abs(predict_values(tree, problem.features) - problem.targets)
    return RegressionCertificate(
        objective=float(exact),
        normalised_objective=float(exact) / baseline if baseline > 0 else math.nan,
        mae=float(np.average(misses, weights=problem.weights)),
        rmse=math.sqrt(float(np.average(misses**2, weights=problem.weights))),
        n_splits=n_splits(tree),
        depth=depth(tree),
        sensors=problem.sensors_used(tree),
        sensor_cost=problem.sensor_cost_of(tree),
        bound=solution.bound,
        gap=solution.gap,
        scope=scope(problem, solution),
    )


def scope(problem: RegressionProblem, solution: Solution) -> str:
    """Return the trees that a bound speaks of, in words."""
    if math.isinf(solution.bound):
        return "no bound is claimed"
    return f"all axis-aligned trees of depth {problem.depth} with one number in each leaf, {problem.loss} error"


def check_tree(problem: RegressionProblem, tree: Node) -> None:
    """Refuse a tree that breaks a limit of the problem.

    Raises
    ------
    CertificateError
        it does.
    """
    if depth(tree) > problem.depth:
        raise CertificateError(f"the tree has depth {depth(tree)} but the problem allows {problem.depth}")
    if problem.split == "axis" and any(isinstance(split, HyperplaneSplit) for split in splits(tree)):
        raise CertificateError("the tree has a split over a hyperplane but split is 'axis'")
    forbidden = problem.first_forbidden_split(tree)
    if forbidden:
        raise CertificateError(forbidden)
    if problem.sensor_cost_of(tree) > problem.sensor_limit:
        raise CertificateError(
            f"the tree reads sensors of total cost {problem.sensor_cost_of(tree):g}, over the budget of "
            f"{problem.sensor_budget:g}"
        )
    sizes = np.bincount(leaf_index(tree, problem.features), minlength=len(leaves(tree)))
    smallest = int(sizes.argmin())
    if not isinstance(tree, Leaf) and sizes[smallest] < problem.leaf_size:
        raise CertificateError(
            f"leaf {smallest} (from the left) holds {sizes[smallest]} samples but leaf_size is {problem.leaf_size}"
        )


def checked_incumbent(problem: RegressionProblem, incumbent: Node | Solution | None) -> Node | None:
    """Return the incumbent's tree; None where there is no incumbent.

    Raises
    ------
    ProblemError
        it is no tree of the problem.
    """
    tree = incumbent.tree if isinstance(incumbent, Solution) else incumbent
    if tree is None:
        return None
    try:
        check_tree(problem, tree)
    except CertificateError as error:
        raise ProblemError(f"the incumbent is no tree of this problem: {error}; leave it out") from error
    return tree


def _check_claims(problem: RegressionProblem, solution: Solution, exact: Fraction, baseline: float) -> None:
    if solution.objective != float(exact):
        raise CertificateError(
            f"{solution.solver} claims objective {solution.objective} but the tree's own, recounted over "
            f"{problem.n_samples} samples, is {float(exact)}; tree and data do not belong together or one was changed"
        )
    for what, least in (("its own tree has", float(exact)), ("one leaf alone costs", baseline)):
        if solution.bound > least:
            raise CertificateError(
                f"{solution.solver} claims that no tree is below {solution.bound} but {what} {least}"
            )
    if not math.isinf(solution.bound) and (problem.split, problem.leaf_model) != ("axis", "constant"):
        raise CertificateError(f"{solution.solver} claims a bound of trees that no solver here has a proof for")
    if solution.stop is Stop.OPTIMAL and not solution.is_optimal:
        raise CertificateError(
            f"{solution.solver} says optimal but its bound {solution.bound} does not meet its objective {float(exact)}"
        )
    least = problem.least_saving(float(exact))
    if not is_tolerable(solution.tolerance, least):
        raise CertificateError(
            f"{solution.solver} claims the tolerance {solution.tolerance}, too wide to call anything proven; expected "
            f"less than {least}, a hundred-millionth of the tree's objective"
        )
