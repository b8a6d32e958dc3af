"""Run: how a problem is solved, apart from the problem, handed on as one by functions that solve several alike."""

import inspect
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, fields
from types import MappingProxyType
from typing import Any, Literal

import numpy as np

from octmip.errors import ProblemError
from octmip.trees.methods import interruption
from octmip.trees.problem import Problem
from octmip.trees.solution import Limits, ProgressCallback, Solution, Stop
from octmip.trees.tree import Node

Method = Literal["auto", "search", "exact", "oct", "oct_h", "flow", "benders", "cart"]
NO_OPTIONS: Mapping[str, Any] = MappingProxyType({})
SHARED = frozenset({"problem", "limits", "incumbent", "seed", "n_jobs", "progress"})
"""What every solver is called with: no options."""
ASSISTANTS = ("exact", "search")
"""Who may assist HiGHS."""


@dataclass(frozen=True, slots=True)
class Run:
    """Method, limits, seed, threads, options and progress of a solve; see `octmip.solve`.

    Attributes
    ----------
    method
        name of the solver, or "auto".
    limits
        of each solve.
    seed
        of all random choices.
    n_jobs
        threads.
    options
        of the method's own solver.
    progress
        called now and then with the state of the solver.
    """

    method: Method = "auto"
    limits: Limits = field(default_factory=Limits)
    seed: int = 0
    n_jobs: int = 1
    options: Mapping[str, Any] = field(default_factory=lambda: NO_OPTIONS)
    progress: ProgressCallback | None = None


def options_of(solver: Callable[..., Any], request: type[Any] | None = None) -> set[str]:
    """Return the options that a solver takes, by HiGHS those that its request to the engine has too."""
    parameters = inspect.signature(solver).parameters.values()
    options = {parameter.name for parameter in parameters if parameter.kind is not parameter.VAR_KEYWORD} - SHARED
    if request is None:
        return options
    return (options | {field.name for field in fields(request)} | {"assist"}) - SHARED - {"method"}


def check_options(who: str, known: set[str], options: Mapping[str, Any]) -> None:
    """Check the names of options, and the assistants.

    Raises
    ------
    ProblemError
        an option is none of those that `who` takes, or an assistant is unknown.
    """
    unknown = [option for option in options if option not in known]
    if unknown:
        takes = ", ".join(sorted(known)) or "none"
        raise ProblemError(f"{who} takes no option {unknown[0]!r}; expected some of: {takes}")
    assist = options.get("assist", ())
    if not isinstance(assist, tuple | list | set) or not set(assist) <= set(ASSISTANTS):
        raise ProblemError(f"assist is {assist!r}; expected a tuple of some of {', '.join(ASSISTANTS)}")


def until_interrupted(problem: Problem, solve: Callable[[], Solution], name: str, known: Node | None) -> Solution:
    """Return the solution of `solve`; once the call is interrupted, the tree that is known, or the best single leaf.

    Parameters
    ----------
    problem
        that is solved.
    solve
        does so; where the call was interrupted before, it is not called.
    name
        of the solver.
    known
        a tree of the problem.
    """
    with interruption.whole_call():
        if not interruption.is_heard():
            try:
                solution = solve()
            except KeyboardInterrupt:
                interruption.note()
            else:
                if solution.stop is Stop.INTERRUPTED:
                    interruption.note()
                return solution
        tree = problem.best_leaf() if known is None else known
        return Solution(tree, problem.objective(tree), -np.inf, Stop.INTERRUPTED, 0.0, 0, name, "1", 0)
