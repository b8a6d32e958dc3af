"""One proof over several processes: measured on one and two, simulated from recorded tasks up to 1,000 workers.

Measured: the same problem by one thread, and by `octmip.trees.cluster` with one and two processes of this machine;
trees, bounds and evaluated cuts must be the same. Simulated: the cuts of a search are solved one after the other by one
thread, with the processor seconds of each; 5 (the search of one machine), 64 and 512 cuts in work at once. Cuts go to
workers in their order, each to the first that is free, and a cut is there once all but so many before it are back.
Assumed: workers as fast as this machine, `OVERHEAD` seconds a task to send and to fetch it, and what is not a task
(depths one and two, choosing cuts) done by the process that asks, as long as it was measured here.

Killed: `--only 'mu2, depth 4' --kills 5 --threads 2` solves the case by so many processes once more, and kills one of
them, drawn anew, at each of five moments drawn from the time that the proof takes without.
"""

import heapq
import os
import random
import re
import signal
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Future as Promise
from concurrent.futures import ThreadPoolExecutor, wait
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np

from benchmarks.data import published, uci
from benchmarks.tables import Line
from octmip.interfaces.report.markdown import markdown_table
from octmip.trees.cluster import Cluster, open_cluster
from octmip.trees.methods.exact import branch_and_bound
from octmip.trees.methods.options import ExactOptions
from octmip.trees.problem import Problem
from octmip.trees.solution import Limits, Solution

OVERHEAD = 0.005
"""Seconds to send a task and to fetch its result; Dask's scheduler is said to take below a millisecond of them."""
USUAL = 5
"""Cuts in work at once on one machine."""
SIZES = (USUAL, 64, 512)
WORKERS = (1, 2, 8, 32, 128, 1000)
CASES: tuple[tuple[str, int, float], ...] = (
    ("mu2", 3, 0.0),
    ("mu1", 4, 0.0),
    ("skin-segmentation", 4, 0.0),
    ("ct-magic", 3, 0.0),
    ("mu2", 4, 900.0),
)
"""Set, depth, and the limit in seconds from which on it is asked."""
NO_LIMITS = Limits()


SMALL = Problem(np.arange(40.0).reshape(20, 2) % 7, np.arange(20) % 2, depth=3)


def results(limit: float, threads: Sequence[int], only: str = "", kills: int = 0) -> Iterator[Line]:
    """Yield for each case the measured times, and for each number of cuts in work the simulated ones, or the kills.

    `only` is a regular expression on "set, depth D".
    """
    for name, depth, least in CASES:
        size = f"{name}, depth {depth}"
        if not re.search(only, size) if only else limit < least:
            continue
        table = published(name, 0) if name.startswith("mu") else uci(name)
        problem = Problem(table.features, table.labels, depth=depth)
        alone, seconds = timed(problem, Limits(seconds=limit))
        case: Line = {"size": size, "seed": 0, "objective": alone.objective, "alone": seconds}
        for count in threads:
            shared, line = _shared(problem, alone, count)
            yield case | {"kind": "measured", **line}
            if kills:
                yield case | _killed(problem, alone, count, kills, shared.seconds)
        if not kills:
            yield from (case | line for line in _simulated(problem))


def _shared(
    problem: Problem, alone: Solution, count: int, kill: Callable[[Cluster], Any] = id
) -> tuple[Solution, Line]:
    """Return the solution by so many processes, `kill` called when it begins, and whether it is that of one thread."""
    with open_cluster("local", count) as cluster:
        timed(SMALL, cluster=cluster)  # workers import what they need
        kill(cluster)
        shared, wall = timed(problem, cluster=cluster)
    same = (shared.tree, shared.bound, shared.n_nodes) == (alone.tree, alone.bound, alone.n_nodes)
    return shared, {"workers": count, "seconds": wall, "same": same}


def _killed(problem: Problem, alone: Solution, count: int, kills: int, seconds: float) -> Line:
    """Return the line of a proof, of so many seconds, during which processes are killed at random moments."""
    drawn = random.Random(0)
    moments: list[float] = []  # those at which a process was killed: the proof may end before others

    def kill_one(cluster: Cluster, moment: float) -> None:
        process = drawn.choice(sorted(cluster.client.run(os.getpid).values()))
        os.kill(process, signal.SIGKILL)
        moments.append(round(moment, 1))

    def kill(cluster: Cluster) -> None:
        for moment in sorted(drawn.uniform(0.0, seconds) for _ in range(kills)):
            timer = threading.Timer(moment, kill_one, (cluster, moment))
            timer.daemon = True
            timer.start()

    _, line = _shared(problem, alone, count, kill)
    return {"kind": "killed", "moments": moments, **line}


def _simulated(problem: Problem) -> Iterator[Line]:
    for size in SIZES:
        levels, serial = recorded(problem, size)
        work = sum(map(sum, levels))
        simulated = {str(n): serial + makespan(levels, size, n) for n in WORKERS}
        tasks = {"tasks": sum(map(len, levels)), "longest": max(map(max, levels))}
        yield {"kind": "simulated", "in_work": size, "work": work, "serial": serial, **tasks, "seconds": simulated}


def timed(problem: Problem, limits: Limits = NO_LIMITS, cluster: Any = None) -> tuple[Solution, float]:
    """Return the solution of a problem and the wall seconds that it took."""
    start = time.perf_counter()
    return branch_and_bound(problem, limits=limits, options=ExactOptions(cluster=cluster)), time.perf_counter() - start


@dataclass(slots=True)
class Recorder(Cluster):
    """A cluster of one thread that notes the processor seconds of each task, by level."""

    levels: dict[int, list[float]] = field(default_factory=dict)
    pool: ThreadPoolExecutor = field(default_factory=lambda: ThreadPoolExecutor(1))

    def share(self, value: object) -> Any:
        """Return the value."""
        return value

    def submit(self, function: Callable[..., Any], shared: Any, *arguments: Any) -> "Recorded":
        """Submit a task."""
        return Recorded(self.pool.submit(self._run, function, shared, *arguments))

    def _run(self, function: Callable[..., Any], shared: Any, level: int, *arguments: Any) -> Any:
        start = time.process_time()
        found = function(shared, level, *arguments)
        self.levels.setdefault(level, []).append(time.process_time() - start)
        return found


class Recorded(NamedTuple):
    """A task of a recorder, as `octmip.trees.cluster.Future` has it."""

    promise: Promise[Any]

    def done(self) -> bool:
        """Whether it has ended."""
        return self.promise.done()

    def wait(self, seconds: float) -> bool:
        """Wait for its end, so long at most."""
        return bool(wait([self.promise], seconds).done)

    def result(self) -> Any:
        """Return the result."""
        return self.promise.result()

    def cancel(self) -> object:
        """Give it up."""
        return self.promise.cancel()


def recorded(problem: Problem, size: int) -> tuple[list[list[float]], float]:
    """Return the processor seconds of the tasks of each level, and those of all that is no task."""
    recorder = Recorder(None, size)
    start = time.process_time()
    branch_and_bound(problem, options=ExactOptions(cluster=recorder))
    total = time.process_time() - start
    levels = list(recorder.levels.values())
    return levels, max(0.0, total - sum(map(sum, levels)))


def makespan(levels: Sequence[Sequence[float]], size: int, n_workers: int) -> float:
    """Return the seconds that so many workers take for all levels, one after the other, `size` cuts in work.

    >>> makespan([[1.0, 1.0, 2.0]], 8, 2) == 3.0 + 2 * OVERHEAD
    True
    >>> makespan([[1.0, 1.0, 2.0]], 1, 2) == 4.0 + 3 * OVERHEAD
    True
    """
    seconds = 0.0
    for tasks in levels:
        free, entered = [0.0] * n_workers, [0.0] * size
        for task in tasks:
            start = max(heapq.heappop(free), entered[-size])
            heapq.heappush(free, start + task + OVERHEAD)
            entered.append(max(entered[-1], start + task + OVERHEAD))
        seconds += entered[-1]
    return seconds


def summary(lines: Sequence[Line]) -> str:
    """Return the measured table and the simulated one."""
    measured = [line for line in lines if line["kind"] != "simulated"]
    rows = [
        {
            "case": line["size"],
            "processes": line["workers"],
            "wall s": round(line["seconds"], 2),
            "one thread, wall s": round(line["alone"], 2),
            "killed after s": ", ".join(map(str, line.get("moments", ()))),
            "same tree, bound, cuts": "yes" if line["same"] else "NO",
        }
        for line in measured
    ]
    simulated = [
        {
            "case": line["size"],
            "in work": line["in_work"],
            "tasks": line["tasks"],
            "longest s": round(line["longest"], 2),
        }
        | {f"{n} workers, s": round(line["seconds"][str(n)], 2) for n in WORKERS}
        for line in lines
        if line["kind"] == "simulated"
    ]
    return "\n\n".join(markdown_table(table) for table in (rows, simulated) if table)
