"""Run: how a problem is solved, apart from the problem, handed on as one by functions that solve several alike."""

from dataclasses import dataclass, field
from typing import Literal

from octmip.trees.methods.options import NO_OPTIONS, Options, refuse_untyped
from octmip.trees.solution import Limits, ProgressCallback

Method = Literal["auto", "search", "exact", "oct", "oct_h", "flow", "benders", "cart"]


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

    Raises
    ------
    ProblemError
        the options are of none of their classes.
    """

    method: Method = "auto"
    limits: Limits = field(default_factory=Limits)
    seed: int = 0
    n_jobs: int = 1
    options: Options = NO_OPTIONS
    progress: ProgressCallback | None = None

    def __post_init__(self) -> None:
        refuse_untyped(self.options, self.method)
