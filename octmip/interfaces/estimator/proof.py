"""The warning of a fit whose proof a limit has ended."""

import math
import warnings

from sklearn.exceptions import ConvergenceWarning

from octmip.trees.problem import Problem
from octmip.trees.registry import chosen_method, solvers_of
from octmip.trees.solution import Solution, Stop

ENDED = {
    Stop.TIME: "at its limit of {seconds:g} s",
    Stop.MEMORY: "at its limit of memory",
    Stop.NUMERICS: "where float64 can prove no more",
    Stop.INTERRUPTED: "when it was interrupted",
}
CURE = {
    Stop.TIME: "give more seconds, or less to prove (max_depth, columns)",
    Stop.MEMORY: "give less to prove (max_depth, columns)",
    Stop.NUMERICS: "scale weights and costs to whole numbers",
    Stop.INTERRUPTED: "fit again for the rest of the proof",
}


def method_proves(problem: Problem, method: str) -> bool:
    """Whether a method promises a proof: "search", "cart", and "auto" for hyperplanes do not."""
    return solvers_of(problem)[chosen_method(problem, method)].proves


def warn_unproven(solution: Solution, proves: bool, seconds: float) -> None:
    """Warn where a method that proves did not: a better tree may exist, and the gap says how much better."""
    if solution.meets_bound or not proves:
        return
    ended = ENDED.get(solution.stop, "early").format(seconds=seconds)
    cure = CURE.get(solution.stop, "give more seconds")
    warnings.warn(
        f"the proof ended {ended}: {_claim(solution)}; the fitted tree is the best one found; {cure}",
        ConvergenceWarning,
        stacklevel=4,
    )


def _claim(solution: Solution) -> str:
    if math.isinf(solution.gap) or solution.bound <= 0:
        return f"the objective is {solution.objective:.6g}, and no bound above 0 is proven (gap_ {solution.gap:.3g})"
    return (
        f"the objective is {solution.objective:.6g}, and no tree is below {solution.bound:.6g} "
        f"(gap_ {solution.gap:.3g})"
    )
