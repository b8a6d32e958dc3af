"""The worst case of one tree while gauges are off, recounted sample by sample, and its certificate. Imports no solver.

worst case   for every set S of at most `off` of the sensors that the tree reads: a sample that a cut on a sensor of S
             may send either way goes either way, and pays the most that any leaf asks that it may reach. Largest sum
             over S. Each sample for itself: readings drift in time
constant     the same with one error for each gauge over all samples, the worst one of its band: never above the worst
             case. Piecewise constant in the errors, so that finitely many are tried (`constant.py`)
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import Any

import numpy as np
from numpy.typing import NDArray

from octmip.errors import CertificateError, ProblemError
from octmip.trees.certificate import check_optimality, checked_leaf_index, first_forbidden_split
from octmip.trees.problem import Problem
from octmip.trees.solution import Solution
from octmip.trees.tree import Leaf, Node, Split, complexity
from octmip.trees.worst_case.bands import Amount, Bands
from octmip.trees.worst_case.constant import ConstantBias, worst_constant


@dataclass(frozen=True, slots=True)
class WorstCase:
    """What a tree costs while gauges are off, in units of the problem's objective.

    Attributes
    ----------
    plain
        with no gauge off: the objective of the problem.
    worst
        in the worst case, each reading off by its own amount.
    gauges
        that are off then; () where none makes it worse.
    by_gauges
        the same for every set of as many gauges as may be off.
    constant
        the worst with one constant error of each gauge; None where there are too many sets of errors to try.
    """

    plain: float
    worst: float
    gauges: tuple[str, ...]
    by_gauges: Mapping[tuple[str, ...], float]
    constant: ConstantBias | None


def worst_case(problem: Problem, tree: Node, bands: Amount | Mapping[str, Amount] | Bands, off: int = 1) -> WorstCase:
    """Return what a tree costs in the worst case.

    Parameters
    ----------
    problem
        of any depth, with ``split="axis"``.
    tree
        of features of the problem.
    bands
        see `Bands.of`.
    off
        at most so many of the sensors are off at a time.

    Raises
    ------
    ProblemError
        `off` is not a whole number of 1 or more, a band is wrong, or the tree has a split over several features.
    """
    bands = bands if isinstance(bands, Bands) else Bands.of(problem, bands)
    sets = sets_off(problem, tree, bands, off)
    plain = problem.objective(tree)
    by_gauges = {gauges: _cost(problem, tree, bands, gauges) for gauges in sets}
    gauges = max(by_gauges, key=lambda names: by_gauges[names])
    worst = by_gauges[gauges]
    return WorstCase(
        plain, worst, gauges if worst > plain else (), by_gauges, worst_constant(problem, tree, bands, sets, plain)
    )


def sets_off(problem: Problem, tree: Node, bands: Bands, off: int) -> list[tuple[str, ...]]:
    """Return the largest sets of sensors that may be off together: of those that the tree reads and that have a band.

    Costs never fall when more sensors are off, so that smaller sets need not be tried.
    """
    if isinstance(off, bool) or not isinstance(off, int) or off < 1:
        raise ProblemError(f"off is {off!r}; expected a whole number of 1 or more, the most gauges off at a time")
    forbidden = first_forbidden_split(problem, tree)
    if forbidden:
        raise ProblemError(f"{forbidden}; give a tree of the problem")
    able = bands.sensors(problem)
    read = [name for name in problem.sensors_used(tree) if name in able]
    return list(combinations(read, min(off, len(read))))


def _cost(problem: Problem, tree: Node, bands: Bands, gauges: tuple[str, ...]) -> float:
    paid = problem.weights * most_paid(problem, tree, bands, gauges, problem.costs, problem.codes)
    total = float(paid.sum()) if problem.has_integer_costs else math.fsum(paid)
    return total + problem.leaf_penalty * complexity(tree)


def most_paid(
    problem: Problem,
    tree: Node,
    bands: Bands,
    gauges: Sequence[str],
    costs: NDArray[Any],
    rows: NDArray[np.int64],
) -> NDArray[Any]:
    """Return the most that each sample, of a row of the costs, may pay while some sensors are off, (n_samples,)."""
    is_off = np.isin(np.array(problem.sensors), gauges)[problem.sensor_index]
    low = np.where(is_off, bands.low, problem.features)
    high = np.where(is_off, bands.high, problem.features)
    most = np.full(problem.n_samples, -1, dtype=costs.dtype)
    stack: list[tuple[Node, NDArray[np.bool_]]] = [(tree, np.ones(problem.n_samples, dtype=bool))]
    while stack:
        node, reach = stack.pop()
        if isinstance(node, Leaf):
            most = np.where(reach, np.maximum(most, costs[rows, node.label]), most)
            continue
        assert isinstance(node, Split)
        stack.append((node.left, reach & (low[:, node.feature] <= node.threshold)))
        stack.append((node.right, reach & (high[:, node.feature] > node.threshold)))
    return most


def certify_worst_case(
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
    check_optimality(solution.solver, solution, solution.objective, problem.least_saving, problem.words_of_saving)
