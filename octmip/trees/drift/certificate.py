"""The certificate of a tree that survives drift: recounted from problem, bands and tree. Imports no solver."""

from collections.abc import Mapping

from octmip.errors import CertificateError
from octmip.trees.certificate import checked_leaf_index
from octmip.trees.drift.bands import Amount
from octmip.trees.drift.recount import WorstCase, worst_case
from octmip.trees.problem import Problem
from octmip.trees.solution import Solution, Stop, is_tolerable


def certify_drift(
    problem: Problem, solution: Solution, bands: Amount | Mapping[str, Amount], off: int = 1
) -> WorstCase:
    """Recompute what a solution claims and return its worst case.

    Raises
    ------
    CertificateError
        there is no tree, it breaks a limit of the problem, or objective, bound or stop are not what they say.
    """
    if solution.tree is None:
        raise CertificateError(f"{solution.solver} found no tree (stop: {solution.stop}); there is nothing to certify")
    checked_leaf_index(problem, solution.tree)
    found = worst_case(problem, solution.tree, bands, off)
    slack = 0.0 if problem.has_integer_costs else 1e-12 * abs(found.worst)
    if abs(solution.objective - found.worst) > slack:
        raise CertificateError(
            f"{solution.solver} claims the worst case {solution.objective} but it is {found.worst}, recounted over "
            f"{problem.n_samples} samples and {len(found.by_gauges)} sets of gauges; tree, data and bands do not "
            "belong together or one was changed"
        )
    if found.constant is not None and found.constant.cost > found.worst + slack:
        raise CertificateError(
            f"one constant error costs {found.constant.cost}, more than the worst case {found.worst} of all errors"
        )
    _check_bound(problem, solution, min(found.worst, problem.baseline) + slack)
    return found


def _check_bound(problem: Problem, solution: Solution, least: float) -> None:
    # A leaf reads no gauge, so no true bound lies above the best one.
    if solution.bound > least + solution.tolerance:
        raise CertificateError(
            f"{solution.solver} claims that no worst case is below {solution.bound} but one of {least} is known"
        )
    if solution.stop is Stop.OPTIMAL and not solution.is_optimal:
        raise CertificateError(
            f"{solution.solver} says optimal but its bound {solution.bound} does not meet {solution.objective}"
        )
    if not is_tolerable(solution.tolerance, problem.least_saving):
        raise CertificateError(
            f"{solution.solver} claims the tolerance {solution.tolerance}; expected 0 or more and less than "
            f"{problem.least_saving}, what one sample or split alone can save"
        )
