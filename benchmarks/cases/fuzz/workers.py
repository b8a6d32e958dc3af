"""What a killed worker costs: proofs and searches shared over two processes, which are killed at random moments.

Each of `N_SOLVES` short solves (proofs and searches in turn) meets a kill: half of them before the problem is sent, the
others while it is solved; one in five kills both workers. The tree must be that of one machine. Short solves, as the
moments at which something is on its way are then a large part of each: the problem to its workers, a task, a result.
"""

import os
import random
import signal
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from functools import partial
from typing import Any

import numpy as np

from benchmarks.tables import Line
from octmip.interfaces.report.markdown import markdown_table
from octmip.trees.methods.cluster import open_cluster
from octmip.trees.methods.exact import branch_and_bound
from octmip.trees.methods.options import ExactOptions, Options, SearchOptions
from octmip.trees.methods.search import local_search
from octmip.trees.question.problem import Problem

N_SOLVES = 40
MOST_SECONDS = 120.0
"""A solve that takes longer is said to hang."""

Solve = Callable[..., Any]


def results(limit: float, threads: Sequence[int]) -> Iterator[Line]:
    """Yield a line for each seed of kills that fits in so many seconds, one at least."""
    began, seed = time.perf_counter(), 0
    while seed == 0 or time.perf_counter() - began < limit:
        yield {"size": "two workers", "seed": seed, **kill_workers(seed, N_SOLVES)}
        seed += 1


def kill_workers(seed: int, n_solves: int) -> dict[str, Any]:
    """Solve so many times, each time with a kill; the number of kills, of other answers, and what these were."""
    rng = random.Random(seed)
    kinds: list[tuple[Solve, type[Options], Problem]] = [
        (branch_and_bound, ExactOptions, _problem(400)),
        (local_search, SearchOptions, _problem(600)),
    ]
    trees = [solve(problem).tree for solve, _, problem in kinds]
    n_kills, bad = 0, []
    with open_cluster("local", 2) as cluster:
        for k in range(n_solves):
            (solve, options, problem), tree = kinds[k % 2], trees[k % 2]
            cluster.client.wait_for_workers(1)
            pids = list(cluster.client.run(os.getpid, on_error="ignore").values())[: 1 + (rng.random() < 0.2)]
            running = _Solve(partial(solve, problem, options=options(cluster=cluster)))
            if is_early := rng.random() < 0.5:
                n_kills += sum(map(_kill, pids))
                time.sleep(0.1 * rng.random())
            running.start()
            if not is_early:
                time.sleep(0.3 * rng.random())
                n_kills += sum(map(_kill, pids))
            running.join(MOST_SECONDS)
            if getattr(running.answer, "tree", None) != tree:
                bad.append(repr(running.answer))
    return {"solves": n_solves, "kills": n_kills, "bad": len(bad), "answers": bad}


class _Solve(threading.Thread):
    """A solve on a cluster, and its answer: a solution, what it raised, or "hangs"."""

    def __init__(self, call: Callable[[], Any]) -> None:
        super().__init__(daemon=True)
        self._call = call
        self.answer: Any = "hangs"

    def run(self) -> None:
        try:
            self.answer = self._call()
        except Exception as error:  # whatever it raises is not the answer
            self.answer = error


def _kill(pid: int) -> bool:
    try:
        os.kill(pid, signal.SIGKILL)
    except ProcessLookupError:
        return False
    return True


def _problem(n: int) -> Problem:
    rng = np.random.default_rng(5)
    return Problem(rng.integers(0, 90, (n, 5)).astype(float), rng.integers(0, 3, n), depth=3)


def summary(lines: Sequence[Line]) -> str:
    """Return solves, kills and other answers."""
    return markdown_table([{key: sum(line[key] for line in lines) for key in ("solves", "kills", "bad")}])
