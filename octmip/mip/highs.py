"""HiGHS: one run of the solver on a model, with limits, Ctrl-C, progress, a start and injected incumbents.

HiGHS runs in a thread of its own while this one waits: so Ctrl-C reaches Python, the run ends at its next callback, and
incumbent and bound survive (`Highs.run` in the calling thread loses them). The waiting thread also keeps the time,
which HiGHS looks at too rarely within a relaxation, and the memory, for which HiGHS has no limit.
"""

import math
import os
import threading
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import highspy
import numpy as np
from numpy.typing import NDArray

from octmip.errors import SolverError
from octmip.mip.rows import Rows
from octmip.solution import Limits, Progress, ProgressCallback, Stop

VERSION: str = highspy.Highs().version()  # type: ignore[no-untyped-call]
POLL = 0.02  # seconds between two looks at Ctrl-C and progress

_STOPS = {
    highspy.HighsModelStatus.kOptimal: Stop.OPTIMAL,
    highspy.HighsModelStatus.kTimeLimit: Stop.TIME,
    highspy.HighsModelStatus.kSolutionLimit: Stop.NODES,
    highspy.HighsModelStatus.kIterationLimit: Stop.NODES,
    highspy.HighsModelStatus.kInterrupt: Stop.INTERRUPTED,
    highspy.HighsModelStatus.kMemoryLimit: Stop.MEMORY,
    highspy.HighsModelStatus.kInfeasible: Stop.OPTIMAL,
}


@dataclass(frozen=True, slots=True)
class Options:
    """How HiGHS is run.

    Attributes:
        limits: at which to stop; memory counts what the process has grown by since the run began.
        seed: of its random choices.
        threads: that it may use.
        tolerance: feasibility tolerance of integer solutions, integrality included.
        absolute_gap: the proof may stop when incumbent and bound are this close.
        lp_solver: of the relaxations that have nothing to start from: "simplex", "ipm", "choose".
    """

    limits: Limits = Limits()  # noqa: RUF009  (frozen)
    seed: int = 0
    threads: int = 1
    tolerance: float = 1e-6
    absolute_gap: float = 1e-6
    lp_solver: str = "choose"


@dataclass(frozen=True, slots=True, eq=False)
class Outcome:
    """What one run of HiGHS came to.

    Attributes:
        values: (n_columns,) the best solution, None without one.
        objective: its objective; +inf without one.
        bound: dual bound; -inf without one, +inf when the model is proven infeasible.
        stop: why it ended.
        n_nodes: nodes of its tree.
        seconds: wall time [s].
        first_incumbent: objective of the first solution it had, the start's when that was accepted.
        root_bound: dual bound when the root node was left (when the run ended, if it never was).
    """

    values: NDArray[np.float64] | None
    objective: float
    bound: float
    stop: Stop
    n_nodes: int
    seconds: float
    first_incumbent: float
    root_bound: float


@dataclass(slots=True)
class _State:
    """What the callbacks, in HiGHS's threads, and the waiting thread tell each other."""

    objective: float = math.inf
    bound: float = -math.inf
    n_nodes: int = 0
    first_incumbent: float = math.inf
    root_bound: float = -math.inf
    stop: Stop | None = None  # why the waiting thread wants an end
    error: BaseException | None = None


def run(
    rows: Rows,
    options: Options,
    *,
    start: NDArray[np.float64] | None = None,
    progress: ProgressCallback | None = None,
    inject: Callable[[float], NDArray[np.float64] | None] | None = None,
) -> Outcome:
    """Solve a model and return what came of it.

    Args:
        start: (n_columns,) a full solution to start from.
        progress: called in this thread while HiGHS runs; what it raises stops the run and is raised again.
        inject: called in HiGHS's thread with its best objective; may return a better solution (n_columns,).

    Raises:
        SolverError: HiGHS refused the model or failed.
    """
    began = time.perf_counter()
    highs = load(rows)
    _set_options(highs, options)
    state = _State()
    _subscribe(highs, state, inject)
    if start is not None:
        solution = highspy.HighsSolution()
        solution.col_value = start.tolist()
        highs.setSolution(solution)
    _wait(highs, state, options.limits, progress, began)
    return _outcome(highs, state, time.perf_counter() - began)


def load(rows: Rows, *, named: bool = False) -> highspy.Highs:
    """Return a silent HiGHS that holds a model, with the names of columns and rows if `named`.

    Raises:
        SolverError: HiGHS refused the model.
    """
    matrix = rows.matrix()
    lp = highspy.HighsLp()
    lp.num_col_, lp.num_row_ = rows.n_columns, rows.n_rows
    lp.col_cost_, lp.offset_ = rows.cost, rows.offset
    lp.col_lower_, lp.col_upper_ = rows.lower, rows.upper
    lp.row_lower_, lp.row_upper_ = rows.row_bounds
    lp.a_matrix_.format_ = highspy.MatrixFormat.kRowwise
    lp.a_matrix_.start_, lp.a_matrix_.index_, lp.a_matrix_.value_ = matrix.indptr, matrix.indices, matrix.data
    kinds = (highspy.HighsVarType.kContinuous, highspy.HighsVarType.kInteger)
    lp.integrality_ = [kinds[i] for i in rows.is_integer.tolist()]
    if named:
        lp.col_names_, lp.row_names_ = rows.column_names(), rows.row_names()
    highs = highspy.Highs()  # type: ignore[no-untyped-call]
    highs.setOptionValue("output_flag", False)
    if highs.passModel(lp) == highspy.HighsStatus.kError:
        raise SolverError(f"HiGHS {VERSION} refused a model of {rows.n_rows} rows and {rows.n_columns} columns")
    return highs


def write(rows: Rows, path: Path) -> None:
    """Write a model to a file that any solver reads: .mps or .lp.

    Raises:
        SolverError: HiGHS could not write it.
    """
    if path.suffix not in (".mps", ".lp"):
        raise SolverError(f"model file {path} ends in {path.suffix!r}; expected .mps or .lp")
    if load(rows, named=True).writeModel(str(path)) == highspy.HighsStatus.kError:
        raise SolverError(f"HiGHS {VERSION} could not write the model to {path}; is the folder there and writable?")


def relax(rows: Rows, seconds: float = math.inf) -> float:
    """Return the bound of the linear relaxation of a model; -inf when `seconds` do not suffice."""
    highs = load(rows)
    highs.setOptionValue("solve_relaxation", True)
    highs.setOptionValue("time_limit", seconds)
    highs.run()
    is_solved = highs.getModelStatus() == highspy.HighsModelStatus.kOptimal
    return float(highs.getInfo().objective_function_value) if is_solved else -math.inf


def _set_options(highs: highspy.Highs, options: Options) -> None:
    limits = options.limits
    values: dict[str, float | str] = {
        "time_limit": limits.seconds,
        "mip_rel_gap": limits.gap,
        "mip_abs_gap": options.absolute_gap,
        "mip_lp_solver": options.lp_solver,
        "mip_feasibility_tolerance": options.tolerance,
        "primal_feasibility_tolerance": min(options.tolerance, 1e-7),
        "random_seed": options.seed % 2**31,
        "threads": options.threads,
        "parallel": "on" if options.threads > 1 else "off",
    }
    if math.isfinite(limits.nodes):
        values["mip_max_nodes"] = int(limits.nodes)
    for name, value in values.items():
        if highs.setOptionValue(name, value) == highspy.HighsStatus.kError:
            raise SolverError(f"HiGHS {VERSION} refused option {name} = {value!r}")


def _subscribe(
    highs: highspy.Highs, state: _State, inject: Callable[[float], NDArray[np.float64] | None] | None
) -> None:
    def look(event: highspy.HighsCallbackEvent) -> None:
        out = event.data_out
        state.objective, state.bound, state.n_nodes = out.mip_primal_bound, out.mip_dual_bound, out.mip_node_count
        if state.n_nodes <= 1:
            state.root_bound = max(state.root_bound, state.bound)
        if state.stop is not None:
            event.interrupt()

    def obey(event: highspy.HighsCallbackEvent) -> None:
        if state.stop is not None:
            event.interrupt()

    def note_incumbent(event: highspy.HighsCallbackEvent) -> None:
        if math.isinf(state.first_incumbent):
            state.first_incumbent = event.data_out.objective_function_value

    def give(event: highspy.HighsCallbackEvent) -> None:
        assert inject is not None
        try:
            values = inject(event.data_out.mip_primal_bound)
        except BaseException as error:  # raised again in the waiting thread: HiGHS would swallow it here
            state.error, state.stop = error, Stop.INTERRUPTED
            return
        if values is not None and event.data_in is not None:
            event.data_in.setSolution(values)

    highs.cbMipInterrupt.subscribe(look)
    highs.cbSimplexInterrupt.subscribe(obey)
    highs.cbIpmInterrupt.subscribe(obey)
    highs.cbMipImprovingSolution.subscribe(note_incumbent)
    if inject is not None:
        highs.cbMipUserSolution.subscribe(give)


def _wait(highs: highspy.Highs, state: _State, limits: Limits, progress: ProgressCallback | None, began: float) -> None:
    """Run HiGHS in its own thread and wait; limits, Ctrl-C and errors of `progress` stop it."""

    def work() -> None:
        highs.run()
        # Threads are HiGHS's global state: the next run may ask for another number of them.
        highspy.Highs.resetGlobalScheduler(False)

    most_memory = resident_bytes() + limits.memory
    thread = threading.Thread(target=work, daemon=True)
    thread.start()
    while thread.is_alive():
        try:
            thread.join(POLL)
            if state.stop is None:
                seconds = time.perf_counter() - began
                state.stop = _reached(limits, seconds, most_memory)
                if progress is not None and thread.is_alive():
                    progress(Progress(seconds, state.objective, state.bound, state.n_nodes))
        except KeyboardInterrupt:
            state.stop = Stop.INTERRUPTED
        except BaseException as error:
            state.error, state.stop = error, Stop.INTERRUPTED
    if state.error is not None:
        raise state.error


def _reached(limits: Limits, seconds: float, most_memory: float) -> Stop | None:
    """Return the limit that is reached, None while there is none."""
    if seconds > limits.seconds:
        return Stop.TIME
    return Stop.MEMORY if resident_bytes() > most_memory else None


def resident_bytes() -> float:
    """Return the memory that this process holds, 0 where the system does not tell (no limit is kept there)."""
    try:
        return float(int(Path("/proc/self/statm").read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE"))
    except OSError:
        return 0.0


def _outcome(highs: highspy.Highs, state: _State, seconds: float) -> Outcome:
    status, info = highs.getModelStatus(), highs.getInfo()
    if status not in _STOPS:
        raise SolverError(f"HiGHS {VERSION} ended with {status.name} after {seconds:.1f} s; expected a solution")
    has_solution = info.primal_solution_status == int(highspy.SolutionStatus.kSolutionStatusFeasible)
    is_infeasible = status == highspy.HighsModelStatus.kInfeasible
    is_interrupted = status == highspy.HighsModelStatus.kInterrupt
    bound = math.inf if is_infeasible else float(info.mip_dual_bound)
    return Outcome(
        values=np.array(highs.getSolution().col_value) if has_solution and not is_infeasible else None,
        objective=float(info.objective_function_value) if has_solution and not is_infeasible else math.inf,
        bound=bound if math.isfinite(bound) or is_infeasible else -math.inf,
        stop=state.stop if is_interrupted and state.stop is not None else _STOPS[status],
        n_nodes=max(int(info.mip_node_count), 0),
        seconds=seconds,
        first_incumbent=state.first_incumbent,
        root_bound=bound if state.n_nodes <= 1 else state.root_bound,
    )
