"""Run: how a problem is solved, apart from the problem, handed on as one by functions that solve several alike."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Any, Literal

from octmip.solution import Limits, ProgressCallback

Method = Literal["auto", "search", "exact", "oct", "oct_h", "flow", "benders", "cart"]
NO_OPTIONS: Mapping[str, Any] = MappingProxyType({})


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
