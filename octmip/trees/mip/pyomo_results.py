"""What a solver of Pyomo said at its end: by which condition, with which solution and bound.

Pyomo has three kinds of results, and each has names of its own: those of `pyo.SolverFactory`, those of
`pyomo.contrib.solver` and those of `pyomo.contrib.appsi`.
"""

import enum
import math
from dataclasses import dataclass
from typing import Any

from octmip.trees.answer.solution import Stop

NO_ANSWER = ("infeasible", "provenInfeasible", "locallyInfeasible", "unbounded", "infeasibleOrUnbounded")
"""The conditions that deny every solution, or every best one, of a model."""
PROVEN = ("optimal", "globallyOptimal", "convergenceCriteriaSatisfied")
"""The conditions under which a solution is the solver's best one."""
STOPS = {
    "maxTimeLimit": Stop.TIME,
    "maxIterations": Stop.NODES,
    "maxEvaluations": Stop.NODES,
    "iterationLimit": Stop.NODES,
    "userInterrupt": Stop.INTERRUPTED,
    "interrupted": Stop.INTERRUPTED,
}
"""The conditions of a run that a limit ended."""
UNNAMED = "another solver"
"""A solver that does not say its name."""
LARGEST = 1e30
"""Of an objective: CBC says 1e50 where it has none."""


@dataclass(frozen=True, slots=True)
class Report:
    """What a solver said at its end.

    Attributes
    ----------
    solver
        its name.
    condition
        why it ended, by the name that Pyomo has for it; "" if nothing is known.
    incumbent
        the objective of its solution; NaN where it states none.
    bound
        the objective that no solution lies below; -inf where it states none.
    """

    solver: str = UNNAMED
    condition: str = ""
    incumbent: float = math.nan
    bound: float = -math.inf

    @property
    def is_proven(self) -> bool:
        """Whether it ended with its best solution."""
        return self.condition in PROVEN

    @property
    def denies(self) -> bool:
        """Whether it says that the model has no solution, or no best one."""
        return self.condition in NO_ANSWER

    @property
    def stop(self) -> Stop:
        """Why it ended."""
        return STOPS.get(self.condition, Stop.FINISHED)


def report_of(results: Any) -> Report:
    """Return what the results of a solver say, of whichever kind they are; None: nothing."""
    if results is None:
        return Report()
    problem, solver = getattr(results, "problem", None), getattr(results, "solver", None)
    condition = getattr(solver if solver is not None else results, "termination_condition", None)
    name = _plain(getattr(results, "solver_name", None)) or _plain(getattr(solver, "name", None)) or UNNAMED
    word = str(_plain(condition) or "unknown")
    incumbent = _number(_first(results, "incumbent_objective", "best_feasible_objective", problem, "upper_bound"))
    bound = _number(_first(results, "objective_bound", "best_objective_bound", problem, "lower_bound"))
    is_meant = word in PROVEN or bound != incumbent  # stopped early, a solver may repeat its incumbent as a bound
    return Report(str(name), word, incumbent, bound if math.isfinite(bound) and is_meant else -math.inf)


def _first(results: Any, new: str, appsi: str, problem: Any, old: str) -> Any:
    """Return the first of three values that there is."""
    if hasattr(results, new):
        return getattr(results, new)
    return getattr(results, appsi) if hasattr(results, appsi) else getattr(problem, old, None)


def _plain(value: Any) -> Any:
    """Return what results of the old kind wrap; the name of a condition; None for what is undefined."""
    value = value.name if isinstance(value, enum.Enum) else getattr(value, "value", value)
    return None if str(value) in ("None", "<undefined>", "undefined") else value


def _number(value: Any) -> float:
    """Return a number that a solver stated, NaN for none."""
    try:
        number = float(_plain(value))
    except (TypeError, ValueError):
        return math.nan
    return number if abs(number) < LARGEST else math.nan
