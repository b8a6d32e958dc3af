"""One proof over several processes: measured on one and two, simulated from recorded tasks up to 1,000 workers.

Measured: the same problem by one thread, and by `octmip.cluster` with one and two processes of this machine; trees,
bounds and evaluated cuts must be the same. Simulated: the cuts of a search are solved one after the other by one
thread, with the processor seconds of each; rounds of 8 (the search of one machine), 64 and 512 cuts. A round's cuts go
to workers in their order, each to the first that is free, and the next round begins when all are back. Assumed: workers
as fast as this machine, `OVERHEAD` seconds a task to send and to fetch it, and what is not a task (depths one and two,
choosing cuts) done by the process that asks, as long as it was measured here.
"""

import heapq
import time
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Future as Promise
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from benchmarks.data import published, uci
from benchmarks.tables import Line
from octmip.cluster import Cluster, open_cluster
from octmip.methods.exact import branch_and_bound
from octmip.problem import Problem
from octmip.report.markdown import markdown_table
from octmip.solution import Limits, Solution

OVERHEAD = 0.005
"""Seconds to send a task and to fetch its result; Dask's scheduler is said to take below a millisecond of them."""
ROUNDS = (8, 64, 512)
WORKERS = (1, 2, 8, 32, 128, 1000)
CASES: tuple[tuple[str, int, float], ...] = (
    ("mu2", 3, 0.0),
    ("mu1", 4, 0.0),
    ("skin-segmentation", 4, 0.0),
    ("ct-magic", 3, 0.0),
    ("mu2", 4, 900.0),
)
"""Set, depth, and the limit in seconds from which on it is asked."""


SMALL = Problem(np.arange(40.0).reshape(20, 2) % 7, np.arange(20) % 2, depth=3)


def results(limit: float, threads: Sequence[int]) -> Iterator[Line]:
    """Yield for each case the measured times, and for each size of rounds the simulated ones."""
    for name, depth, least in CASES:
        if limit < least:
            continue
        table = published(name, 0) if name.startswith("mu") else uci(name)
        problem = Problem(table.features, table.labels, depth=depth)
        alone, seconds = timed(problem, limits=Limits(seconds=limit))
        case: Line = {"size": f"{name}, depth {depth}", "seed": 0, "objective": alone.objective, "alone": seconds}
        for count in threads:
            with open_cluster("local", count) as cluster:
                timed(SMALL, cluster=cluster)  # workers import what they need
                shared, wall = timed(problem, cluster=cluster)
            same = (shared.tree, shared.bound, shared.n_nodes) == (alone.tree, alone.bound, alone.n_nodes)
            yield case | {"kind": "measured", "workers": count, "seconds": wall, "same": same}
        for round_size in ROUNDS:
            rounds, serial = recorded(problem, round_size)
            work = sum(map(sum, rounds))
            simulated = {str(n): serial + makespan(rounds, n) for n in WORKERS}
            tasks = {"rounds": len(rounds), "tasks": sum(map(len, rounds)), "longest": max(map(max, rounds))}
            yield (
                case
                | {"kind": "simulated", "round": round_size, "work": work, "serial": serial, **tasks}
                | {"seconds": simulated}
            )


def timed(problem: Problem, **options: Any) -> tuple[Solution, float]:
    """Return the solution of a problem and the wall seconds that it took."""
    start = time.perf_counter()
    return branch_and_bound(problem, **options), time.perf_counter() - start


@dataclass(slots=True)
class Recorder(Cluster):
    """A cluster of one thread that notes the processor seconds of each task, round by round."""

    rounds: list[list[float]] = field(default_factory=list)
    n_open: int = 0
    pool: ThreadPoolExecutor = field(default_factory=lambda: ThreadPoolExecutor(1))

    def share(self, value: object) -> Any:
        """Return the value."""
        return value

    def submit(self, function: Callable[..., Any], shared: Any, *arguments: object) -> Any:
        """Submit a task; a round begins when none is open."""
        if self.n_open == 0:
            self.rounds.append([])
        self.n_open += 1
        promise: Promise[Any] = self.pool.submit(self._run, function, shared, *arguments)
        return promise

    def _run(self, function: Callable[..., Any], *arguments: object) -> Any:
        start = time.process_time()
        found = function(*arguments)
        self.rounds[-1].append(time.process_time() - start)
        self.n_open -= 1
        return found


def recorded(problem: Problem, round_size: int) -> tuple[list[list[float]], float]:
    """Return the processor seconds of the tasks of each round, and those of all that is no task."""
    recorder = Recorder(None, round_size)
    start = time.process_time()
    branch_and_bound(problem, cluster=recorder)
    total = time.process_time() - start
    rounds = [tasks for tasks in recorder.rounds if tasks]
    return rounds, max(0.0, total - sum(map(sum, rounds)))


def makespan(rounds: Sequence[Sequence[float]], n_workers: int) -> float:
    """Return the seconds that so many workers take for all rounds, one after the other.

    >>> makespan([[1.0, 1.0, 2.0]], 2) == 3.0 + 2 * OVERHEAD
    True
    """
    seconds = 0.0
    for tasks in rounds:
        free = [0.0] * min(n_workers, len(tasks))
        for task in tasks:
            heapq.heappush(free, heapq.heappop(free) + task + OVERHEAD)
        seconds += max(free)
    return seconds


def summary(lines: Sequence[Line]) -> str:
    """Return the measured table and the simulated one."""
    measured = [line for line in lines if line["kind"] == "measured"]
    rows = [
        {
            "case": line["size"],
            "processes": line["workers"],
            "wall s": round(line["seconds"], 2),
            "one thread, wall s": round(line["alone"], 2),
            "same tree, bound, cuts": "yes" if line["same"] else "NO",
        }
        for line in measured
    ]
    simulated = [
        {"case": line["size"], "round": line["round"], "tasks": line["tasks"], "longest s": round(line["longest"], 2)}
        | {f"{n} workers, s": round(line["seconds"][str(n)], 2) for n in WORKERS}
        for line in lines
        if line["kind"] == "simulated"
    ]
    return f"{markdown_table(rows)}\n\n{markdown_table(simulated)}"
