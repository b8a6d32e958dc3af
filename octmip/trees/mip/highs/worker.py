"""Worker: the process that HiGHS runs in. A script of its own that imports HiGHS and numpy and nothing of octmip.

HiGHS looks at limits and calls back between two relaxations, and within one now and then; some relaxations, presolve
and the reading of a model are silent for many seconds. A thread in there cannot be stopped; a process can be killed.

Frames of pickled tuples go both ways, each behind its length in eight bytes (see `octmip.trees.mip.highs.process`):

    to the worker     ("run", job)   ("stop",)
    from the worker   ("started", pid)   ("state", State as a dict)   ("incumbent", objective, values)
                      ("done", what HiGHS ended with)   ("failed", sentence)

The worker ends when its standard input does, or when its parent is another process than at the start: it never outlives
the process that wants its result.
"""

import math
import os
import pickle
import queue
import sys
import threading
import time
import traceback
from dataclasses import asdict, dataclass
from typing import Any, BinaryIO

import highspy
import numpy as np

REPORT = 0.01  # seconds between two reports of bound and nodes
PARENT = 0.5  # seconds between two looks at the parent


@dataclass(slots=True)
class State:
    """The progress of HiGHS."""

    objective: float = math.inf
    bound: float = -math.inf
    n_nodes: int = 0
    first_incumbent: float = math.inf
    root_bound: float = -math.inf


@dataclass(slots=True)
class Commands:
    """The parent's commands since the run began."""

    stop: bool = False


def read_frame(stream: BinaryIO) -> Any:
    """Return the next frame, None at the end of the stream."""
    header = stream.read(8)
    body = stream.read(int.from_bytes(header, "little")) if len(header) == 8 else b""
    return pickle.loads(body) if body and len(body) == int.from_bytes(header, "little") else None


def write_frame(stream: BinaryIO, frame: tuple[Any, ...]) -> None:
    """Write a frame."""
    body = pickle.dumps(frame, protocol=5)
    stream.write(len(body).to_bytes(8, "little"))
    stream.write(body)
    stream.flush()


class SilentHighs(highspy.Highs):
    """HiGHS without a word: from 1.16 on it prints its name when callbacks are enabled, which its constructor does."""

    def __init__(self) -> None:
        super().__init__()  # type: ignore[no-untyped-call] # HiGHS has no annotations
        self.setOptionValue("output_flag", False)

    def enableCallbacks(self) -> None:  # noqa: N802 - HiGHS's name
        """Be silent before anything else is asked."""
        self.setOptionValue("output_flag", False)
        super().enableCallbacks()  # type: ignore[no-untyped-call] # as above

    def run_beside_others(self) -> None:
        """Run in a process in which others may use HiGHS: its threads are the process's.

        From 1.16 on a run that asks for another number of them than the first one ends with an error.
        """
        if self.run() == highspy.HighsStatus.kError:
            self.setOptionValue("threads", 0)  # as many as there are
            self.run()


def load(model: dict[str, Any]) -> SilentHighs | None:
    """Return a silent HiGHS that holds a model, None when it refuses it."""
    lp = highspy.HighsLp()
    lp.num_col_, lp.num_row_ = len(model["cost"]), len(model["row_lower"])
    lp.col_cost_, lp.offset_ = model["cost"], model["offset"]
    lp.col_lower_, lp.col_upper_ = model["lower"], model["upper"]
    lp.row_lower_, lp.row_upper_ = model["row_lower"], model["row_upper"]
    lp.a_matrix_.format_ = highspy.MatrixFormat.kRowwise
    lp.a_matrix_.start_, lp.a_matrix_.index_, lp.a_matrix_.value_ = model["matrix"]
    kinds = (highspy.HighsVarType.kContinuous, highspy.HighsVarType.kInteger)
    lp.integrality_ = [kinds[i] for i in model["is_integer"].tolist()]
    if "names" in model:
        lp.col_names_, lp.row_names_ = model["names"]
    highs = SilentHighs()
    return None if highs.passModel(lp) == highspy.HighsStatus.kError else highs


class Run:
    """One run of HiGHS, its reports written as they come."""

    def __init__(self, job: dict[str, Any], commands: Commands, output: BinaryIO, lock: threading.Lock) -> None:
        self.job, self.commands, self.output, self.lock = job, commands, output, lock
        self.state, self.reported = State(), 0.0

    def tell(self, *frame: Any) -> None:
        """Write a frame to the parent."""
        with self.lock:
            write_frame(self.output, frame)

    def solve(self) -> None:
        """Run HiGHS and report its end."""
        highs = load(self.job["model"])
        if highs is None:
            self.tell("failed", "refused the model")
            return
        for name, value in self.job["options"].items():
            if highs.setOptionValue(name, value) == highspy.HighsStatus.kError:
                self.tell("failed", f"refused option {name} = {value!r}")
                return
        self._subscribe(highs)
        highs.setOptionValue("output_flag", "log_file" in self.job["options"])  # callbacks turned it off
        if self.job["start"] is not None:
            solution = highspy.HighsSolution()
            solution.col_value = self.job["start"].tolist()
            highs.setSolution(solution)
        highs.run()
        # Threads are HiGHS's global state: the next run may ask for another number of them.
        highspy.Highs.resetGlobalScheduler(False)
        self.tell("done", self._end(highs))

    def _subscribe(self, highs: highspy.Highs) -> None:
        highs.cbMipInterrupt.subscribe(self._report)
        highs.cbSimplexInterrupt.subscribe(self._obey)
        highs.cbIpmInterrupt.subscribe(self._obey)
        highs.cbMipImprovingSolution.subscribe(self._note_incumbent)

    def _report(self, event: highspy.HighsCallbackEvent) -> None:
        out, state = event.data_out, self.state
        state.objective, state.bound, state.n_nodes = out.mip_primal_bound, out.mip_dual_bound, out.mip_node_count
        if state.n_nodes <= 1:
            state.root_bound = max(state.root_bound, state.bound)
        now = time.monotonic()
        if now - self.reported >= REPORT:
            self.reported = now
            self.tell("state", asdict(state))
        self._obey(event)

    def _obey(self, event: highspy.HighsCallbackEvent) -> None:
        if self.commands.stop:
            event.interrupt()

    def _note_incumbent(self, event: highspy.HighsCallbackEvent) -> None:
        objective = event.data_out.objective_function_value
        if math.isinf(self.state.first_incumbent):
            self.state.first_incumbent = objective
        self.tell("incumbent", objective, np.array(event.data_out.mip_solution))

    def _end(self, highs: highspy.Highs) -> dict[str, Any]:
        info = highs.getInfo()
        has_solution = info.primal_solution_status == int(highspy.SolutionStatus.kSolutionStatusFeasible)
        return {
            "status": highs.getModelStatus().name,
            "values": np.array(highs.getSolution().col_value) if has_solution else None,
            "objective": float(info.objective_function_value),
            "bound": float(info.mip_dual_bound),
            "n_nodes": max(int(info.mip_node_count), 0),
            "state": asdict(self.state),
        }


def _listen(stream: BinaryIO, jobs: "queue.SimpleQueue[tuple[dict[str, Any], Commands]]") -> None:
    """Hand over jobs and commands until the parent closes the pipe; then end the process, whatever HiGHS does."""
    commands = Commands()
    while (frame := read_frame(stream)) is not None:
        if frame[0] == "run":
            commands = Commands()
            jobs.put((frame[1], commands))
        elif frame[0] == "stop":
            commands.stop = True
    os._exit(0)


def _watch_parent(parent: int) -> None:
    """End the process when its parent has: a copy of the pipe's other end may live on in a sibling."""
    while os.getppid() == parent:
        time.sleep(PARENT)
    os._exit(0)


def main() -> None:
    """Run jobs until the parent ends."""
    stream, output = os.fdopen(os.dup(0), "rb"), os.fdopen(os.dup(1), "wb")
    silence = os.open(os.devnull, os.O_RDWR)
    for descriptor in (0, 1):  # what a library prints must not land between two frames
        os.dup2(silence, descriptor)
    if hasattr(os, "getppid") and sys.platform != "win32":
        threading.Thread(target=_watch_parent, args=(os.getppid(),), daemon=True).start()
    jobs: queue.SimpleQueue[tuple[dict[str, Any], Commands]] = queue.SimpleQueue()
    threading.Thread(target=_listen, args=(stream, jobs), daemon=True).start()
    lock = threading.Lock()
    while True:
        job, commands = jobs.get()
        run = Run(job, commands, output, lock)
        try:
            run.tell("started", os.getpid())
            run.solve()
        except Exception:
            run.tell("failed", traceback.format_exc(limit=-1))


if __name__ == "__main__":
    main()
