"""Case: one question to several solvers; a family of them is one file under benchmarks/cases."""

from collections.abc import Callable
from dataclasses import dataclass

from octmip.trees.question.problem import Problem


@dataclass(frozen=True, slots=True)
class Case:
    """One question to be answered by several solvers, each in a process of its own.

    Attributes
    ----------
    size
        what is asked, in words that name it within its family ("iris, depth 3").
    seed
        of the data.
    build
        returns the problem; called in the solver's process, not measured.
    solvers
        names in `benchmarks.rivals.RIVALS`.
    """

    size: str
    seed: int
    build: Callable[[], Problem]
    solvers: tuple[str, ...]
