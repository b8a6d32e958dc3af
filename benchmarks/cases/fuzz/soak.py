"""Half an hour of mixed problems in one process: memory flat, no thread, file or child left, each result certified.

`python -m benchmarks.run soak --limit 1800`. Problems of every kind are drawn one after the other: axis-aligned and
two-feature proofs, local search, CART, regression trees, counts of near-optimal trees, and HiGHS now and then. Resident
memory is read after each hundred problems, garbage collected before; the first fifth of the time is warm-up (allocator,
imports, caches of fixed size). Flat is: the median of the last fifth at most 5 % above that of the second fifth.
"""

import gc
import os
import statistics
import time
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path

import numpy as np

from benchmarks.tables import Line
from octmip.interfaces.report.markdown import markdown_table
from octmip.trees.certificate import certify
from octmip.trees.losses import SquaredError
from octmip.trees.near_sets import near_optimal
from octmip.trees.problem import Problem
from octmip.trees.set_certificate import certify_set
from octmip.trees.solution import Limits
from octmip.trees.solver import solve
from tests.oracles.strategies import random_problem

EVERY = 100
"""Problems between two readings of memory."""
Generator = np.random.Generator


def axis(rng: Generator) -> None:
    """Prove a small axis-aligned problem of any kind."""
    problem = random_problem(rng)
    certify(problem, solve(problem, n_jobs=1 + int(rng.integers(2))))


def larger(rng: Generator) -> None:
    """Prove a problem whose search has several rounds, or stop it."""
    problem = Problem(rng.integers(0, 50, (300, 5)).astype(float), rng.integers(0, 3, 300), depth=3)
    certify(problem, solve(problem, limits=Limits(seconds=0.3), n_jobs=2))


def lines(rng: Generator) -> None:
    """Prove, or stop, a problem of two-feature splits."""
    problem = Problem(rng.normal(size=(30, 3)), np.arange(30) % 2, depth=2, split="hyperplane", split_size=2)
    certify(problem, solve(problem, "exact", limits=Limits(seconds=0.5)))


def searched(rng: Generator) -> None:
    """Search a deep tree."""
    problem = Problem(rng.normal(size=(200, 6)).round(2), rng.integers(0, 4, 200), depth=5)
    certify(problem, solve(problem, "search", limits=Limits(seconds=0.2)))


def greedy(rng: Generator) -> None:
    """Build CART's tree."""
    problem = Problem(rng.normal(size=(200, 6)), rng.integers(0, 3, 200), depth=4)
    certify(problem, solve(problem, "cart"))


def numbers(rng: Generator) -> None:
    """Prove a regression tree."""
    problem = Problem(
        rng.normal(size=(60, 3)).round(1), rng.integers(0, 9, 60).astype(float), depth=2, loss=SquaredError()
    )
    certify(problem, solve(problem))


def counted(rng: Generator) -> None:
    """Count the trees near the optimum; an enumeration counts them again."""
    problem = Problem(rng.integers(0, 4, (30, 3)).astype(float), rng.integers(0, 2, 30), depth=2)
    found = near_optimal(problem, within=1.0)
    if certify_set(problem, found, found.best(3)) is None:
        raise AssertionError("a set of trees this small is counted again")


def mixed_integer(rng: Generator) -> None:
    """Let HiGHS solve a small problem in a process of its own."""
    problem = Problem(rng.integers(0, 5, (12, 2)).astype(float), np.arange(12) % 2, depth=1)
    certify(problem, solve(problem, "flow", limits=Limits(seconds=2.0)))


KINDS: dict[Callable[[Generator], None], float] = {
    axis: 0.4,
    larger: 0.12,
    lines: 0.05,
    searched: 0.1,
    greedy: 0.1,
    numbers: 0.12,
    counted: 0.1,
    mixed_integer: 0.01,
}
"""Kinds of problems and how often each is drawn."""


def left() -> dict[str, int]:
    """Return what the process holds: threads, open files, children."""
    tasks = list(Path("/proc/self/task").iterdir())
    children = sum(len((task / "children").read_text().split()) for task in tasks)
    return {"threads": len(tasks), "files": len(os.listdir("/proc/self/fd")), "children": children}


def resident() -> float:
    """Return the resident memory [MB], garbage collected."""
    gc.collect()
    return int(Path("/proc/self/statm").read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE") / 1e6


def results(limit: float, threads: Sequence[int]) -> Iterator[Line]:
    """Yield one line: problems by kind, memory over time, what was there at the beginning and is at the end."""
    kinds, shares = list(KINDS), np.array(list(KINDS.values()))
    for kind in kinds:
        kind(np.random.default_rng(0))
    start, first, counts = time.monotonic(), left(), Counter[str]()
    memory: list[tuple[float, float]] = []
    number = 0
    while time.monotonic() - start < limit:
        rng = np.random.default_rng([77, number])
        kind = kinds[int(rng.choice(len(kinds), p=shares / shares.sum()))]
        kind(rng)
        counts[kind.__name__] += 1
        number += 1
        if number % EVERY == 0:
            memory.append((time.monotonic() - start, resident()))
    yield {"size": "mixed problems", "seed": 77, "problems": number, "counts": counts, "memory": memory} | {
        "growth": growth(memory, limit),
        "before": first,
        "after": left(),
    }


def growth(memory: Sequence[tuple[float, float]], limit: float) -> float | None:
    """Return the median of the last fifth of the time over that of the second fifth, less 1; None without readings."""
    parts = [[mb for at, mb in memory if low <= at / limit < high] for low, high in ((0.2, 0.4), (0.8, np.inf))]
    return statistics.median(parts[1]) / statistics.median(parts[0]) - 1.0 if all(parts) else None


def summary(lines: Sequence[Line]) -> str:
    """Return the table."""
    return markdown_table(
        [
            {
                "problems": line["problems"],
                "memory, first and last MB": f"{line['memory'][0][1]:.0f}, {line['memory'][-1][1]:.0f}",
                "growth %": None if line["growth"] is None else round(100 * line["growth"], 2),
                "threads, files, children before": " ".join(map(str, line["before"].values())),
                "after": " ".join(map(str, line["after"].values())),
            }
            for line in lines
            if line["memory"]
        ]
    )
