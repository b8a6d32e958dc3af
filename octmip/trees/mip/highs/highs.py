"""HiGHS: one run of the solver on a model, with limits, Ctrl-C, progress and a start.

HiGHS runs in a process of its own (`octmip.trees.mip.highs.worker`) while this one waits and keeps time and memory:
HiGHS looks at its time too rarely within a relaxation and not at all in presolve, and has no limit of memory. At a
limit, or at Ctrl-C, it is asked to end; if it has not after `GRACE` it is killed, and the last incumbent and bound that
it reported stand.
"""

import math
import os
import time
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import highspy
import numpy as np
from numpy.typing import NDArray

from octmip.errors import SolverError
from octmip.input.files import PathLike
from octmip.trees.answer.solution import Limits, Progress, ProgressCallback, Stop
from octmip.trees.mip.highs import worker
from octmip.trees.mip.highs.process import START, Worker, lent_worker, resident_bytes
from octmip.trees.mip.rows import Rows

VERSION: str = ".".join(
    str(part) for part in (highspy.HIGHS_VERSION_MAJOR, highspy.HIGHS_VERSION_MINOR, highspy.HIGHS_VERSION_PATCH)
)
POLL = 0.02  # seconds between two looks at Ctrl-C and progress
GRACE = 0.5  # seconds that HiGHS has to end by itself once it is asked to

_STOPS = {
    "kOptimal": Stop.OPTIMAL,
    "kTimeLimit": Stop.TIME,
    "kSolutionLimit": Stop.NODES,
    "kIterationLimit": Stop.NODES,
    "kInterrupt": Stop.INTERRUPTED,
    "kMemoryLimit": Stop.MEMORY,
}
"""The stop for each status of HiGHS, by its name. Every model holds a tree without a split, so "infeasible" is an
error of arithmetic like all that is not named: `Stop.NUMERICS`."""


@dataclass(frozen=True, slots=True)
class Options:
    """Options of a run of HiGHS.

    Attributes
    ----------
    limits
        at which to stop; memory counts what HiGHS's process has grown by since the run began.
    seed
        of its random choices.
    threads
        that it may use.
    tolerance
        feasibility tolerance of integer solutions, integrality included.
    dual_tolerance
        of the reduced costs of a relaxation.
    absolute_gap
        the proof may stop when incumbent and bound are this close.
    lp_solver
        of the relaxations that have nothing to start from: "simplex", "ipm", "choose".
    further
        options of HiGHS by its own names.
    log
        file for its log; None: it says nothing.
    """

    limits: Limits = Limits()  # noqa: RUF009  (frozen)
    seed: int = 0
    threads: int = 1
    tolerance: float = 1e-6
    dual_tolerance: float = 1e-7
    absolute_gap: float = 1e-6
    lp_solver: str = "choose"
    further: Mapping[str, bool | int | float | str] = field(default_factory=dict)
    log: PathLike | None = None


@dataclass(frozen=True, slots=True, eq=False)
class Outcome:
    """The outcome of one run of HiGHS.

    Attributes
    ----------
    values
        (n_columns,) the best solution, None without one.
    objective
        its objective, counted from its values; +inf without one.
    claimed
        what HiGHS says its objective is.
    bound
        dual bound; -inf without one.
    stop
        why it ended; `Stop.NUMERICS` when it failed.
    status
        the status of HiGHS itself, or what happened to its process.
    n_nodes
        nodes of its tree.
    seconds
        wall time [s].
    first_incumbent
        objective of the first solution it had, the start's when that was accepted.
    root_bound
        dual bound when the root node was left (when the run ended, if it never was).
    """

    values: NDArray[np.float64] | None
    objective: float
    claimed: float
    bound: float
    stop: Stop
    status: str
    n_nodes: int
    seconds: float
    first_incumbent: float
    root_bound: float


def run(
    rows: Rows,
    options: Options,
    *,
    start: NDArray[np.float64] | None = None,
    progress: ProgressCallback | None = None,
) -> Outcome:
    """Solve a model and return the outcome.

    Parameters
    ----------
    start
        (n_columns,) a full solution to start from.
    progress
        called in this thread while HiGHS runs; what it raises stops the run and is raised again.

    Raises
    ------
    SolverError
        HiGHS refused the model or an option, or its process cannot be started.
    """
    with lent_worker() as lent:
        supervisor = _Supervisor(lent, rows, options.limits, progress)
        return supervisor.over(_job(rows, _settings(options), start))


def arrays(rows: Rows) -> dict[str, Any]:
    """Return a model as `worker.load` takes it."""
    matrix = rows.matrix()
    return {
        "cost": rows.cost,
        "offset": rows.offset,
        "lower": rows.lower,
        "upper": rows.upper,
        "row_lower": rows.row_bounds[0],
        "row_upper": rows.row_bounds[1],
        "matrix": (matrix.indptr, matrix.indices, matrix.data),
        "is_integer": rows.is_integer,
    }


def _job(rows: Rows, settings: dict[str, Any], start: NDArray[np.float64] | None) -> dict[str, Any]:
    return {"model": arrays(rows), "options": settings, "start": start}


def _settings(options: Options) -> dict[str, Any]:
    limits = options.limits
    settings: dict[str, Any] = {
        "time_limit": limits.seconds,
        "mip_rel_gap": limits.gap,
        "mip_abs_gap": options.absolute_gap,
        "mip_lp_solver": options.lp_solver,
        "mip_feasibility_tolerance": options.tolerance,
        "primal_feasibility_tolerance": min(options.tolerance, 1e-7),
        "dual_feasibility_tolerance": options.dual_tolerance,
        "random_seed": options.seed % 2**31,
        **_threads(options.threads),
    }
    if math.isfinite(limits.nodes):
        settings["mip_max_nodes"] = int(limits.nodes)
    if options.log is not None:
        settings |= {"log_file": os.fspath(options.log), "log_to_console": False}
    return settings | dict(options.further)


def _threads(n_threads: int) -> dict[str, Any]:
    """Return the options for so many threads: left to itself, HiGHS takes those of the machine from 1.16 on."""
    return {"threads": n_threads, "parallel": "on" if n_threads > 1 else "off"}


class _Supervisor:
    """The supervision of one run: waits for the worker, keeps the limits, takes its reports."""

    def __init__(self, lent: Worker, rows: Rows, limits: Limits, progress: ProgressCallback | None) -> None:
        self.worker, self.rows, self.limits, self.progress = lent, rows, limits, progress
        self.began = time.perf_counter()
        self.state = worker.State()
        self.values: NDArray[np.float64] | None = None
        self.objective = self.claimed = math.inf
        self.stop: Stop | None = None  # why this side wants an end
        self.patience = math.inf  # when the worker is killed [s since the beginning]
        self.most_memory = math.inf
        self.error: BaseException | None = None

    @property
    def seconds(self) -> float:
        return time.perf_counter() - self.began

    def over(self, job: dict[str, Any]) -> Outcome:
        """Hand over a job and return its outcome."""
        self.worker.send("run", job)
        outcome = None
        while outcome is None:
            try:
                outcome = self._note(self.worker.receive(POLL))
                if outcome is None:
                    self._check()
            except KeyboardInterrupt:
                self._end(Stop.INTERRUPTED)
            except SolverError:
                raise
            except BaseException as error:
                self.error = error
                self._end(Stop.INTERRUPTED)
        if self.error is not None:
            raise self.error
        return outcome

    def _note(self, frame: tuple[Any, ...] | None) -> Outcome | None:
        """Take in what the worker reports; return the outcome when that is the last of it."""
        if self.seconds > self.patience:
            self.worker.close()
            return self._left(f"killed {GRACE} s after the order to end")
        if frame is None:
            return None
        kind, *what = frame
        if kind == "started":
            self.most_memory = resident_bytes(self.worker.process.pid) + self.limits.memory
        elif kind == "state":
            self.state = worker.State(**what[0])
        elif kind == "incumbent":
            self._take(*what)
        elif kind == "done":
            return self._done(what[0])
        elif kind == "failed":
            raise SolverError(f"HiGHS {VERSION} {what[0]}")
        elif kind == "closed":
            return self._closed()
        return None

    def _take(self, claimed: float, values: NDArray[np.float64], *, is_last: bool = False) -> None:
        """Keep a solution that is better than the one so far, or the last one: by its values, not by what is said."""
        objective = self.rows.objective(values)
        if is_last or objective < self.objective:
            self.objective, self.claimed, self.values = objective, claimed, values

    def _closed(self) -> Outcome:
        code = self.worker.process.wait()
        self.worker.close()
        if math.isinf(self.most_memory):
            raise SolverError(f"the process that runs HiGHS ended with code {code} before it began; reinstall highspy")
        self.stop = self.stop or Stop.NUMERICS
        return self._left(f"its process ended by itself with code {code}")

    def _check(self) -> None:
        """Keep the limits and report progress."""
        if self.stop is not None:
            return
        reached = self._reached()
        if reached is not None:
            self._end(reached)
            return
        if self.progress is not None:
            best = min(self.state.objective, self.objective)
            self.progress(Progress(self.seconds, best, self.state.bound, self.state.n_nodes))

    def _reached(self) -> Stop | None:
        """Return the limit that is reached, None while there is none."""
        if self.seconds > self.limits.seconds:
            return Stop.TIME
        if math.isinf(self.most_memory) and self.seconds > START:
            raise SolverError(
                f"HiGHS's process has not started within {START:.0f} s; expected less than 1 s; free the machine"
            )
        return Stop.MEMORY if resident_bytes(self.worker.process.pid) > self.most_memory else None

    def _end(self, reason: Stop) -> None:
        if self.stop is None:
            self.stop, self.patience = reason, self.seconds + GRACE
            self.worker.send("stop")

    def _done(self, end: dict[str, Any]) -> Outcome:
        self.state = worker.State(**end["state"])
        if end["values"] is not None and math.isfinite(end["objective"]):
            self._take(end["objective"], end["values"], is_last=True)
        self.state.n_nodes = end["n_nodes"]
        known = _STOPS.get(end["status"], Stop.NUMERICS)
        stop = self.stop if known is Stop.INTERRUPTED and self.stop is not None else known
        return self._outcome(stop, end["status"], end["bound"])

    def _left(self, status: str) -> Outcome:
        """Return the outcome of a worker that ended without a result, from its last reports.

        The bound may rest on an incumbent whose values did not arrive.
        """
        assert self.stop is not None
        return self._outcome(self.stop, status, min(self.state.bound, self.state.objective))

    def _outcome(self, stop: Stop, status: str, bound: float) -> Outcome:
        bound = bound if math.isfinite(bound) and stop is not Stop.NUMERICS else -math.inf
        return Outcome(
            values=self.values,
            objective=self.objective,
            claimed=self.claimed,
            bound=bound,
            stop=stop,
            status=status,
            n_nodes=self.state.n_nodes,
            seconds=self.seconds,
            first_incumbent=self.state.first_incumbent,
            root_bound=bound if self.state.n_nodes <= 1 else self.state.root_bound,
        )
