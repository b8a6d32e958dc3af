"""Half an hour of every kind of problem in one process: memory flat, no thread, file or child left, no answer wrong.

`python -m benchmarks.run soak --limit 1800` asks the questions of `fuzz_everything` one after the other. Resident
memory is read after each ten seeds, garbage collected before; the first fifth of the time is warm-up (allocator,
imports, caches of fixed size). Flat is: the median of the last fifth at most 5 % above that of the second fifth.
"""

import gc
import os
import statistics
import time
from collections import Counter
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np

from benchmarks.kinds.asked import STREAM, answer, questions
from benchmarks.tables import Line
from octmip.interfaces.report.markdown import markdown_table

EVERY = 10
"""Seeds between two readings of memory."""


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
    """Yield one line: answers by kind, memory over time, what was there at the beginning and is at the end."""
    _answers(0)
    start, first, counts, wrong = time.monotonic(), left(), Counter[str](), dict[str, str]()
    memory: list[tuple[float, float]] = []
    seed = 0
    while time.monotonic() - start < limit:
        seed += 1
        for said in _answers(seed):
            counts[said["method"]] += 1
            wrong |= {said["question"]: said["wrong"]} if said["wrong"] else {}
        if seed % EVERY == 0:
            memory.append((time.monotonic() - start, resident()))
    yield {"size": "every kind of problem", "seed": STREAM, "answers": counts.total(), "counts": counts} | {
        "wrong": wrong,
        "memory": memory,
        "growth": growth(memory, limit),
        "before": first,
        "after": left(),
    }


def _answers(seed: int) -> list[Line]:
    return [answer(*asked) for asked in questions(seed)]


def growth(memory: Sequence[tuple[float, float]], limit: float) -> float | None:
    """Return the median of the last fifth of the time over that of the second fifth, less 1; None without readings."""
    parts = [[mb for at, mb in memory if low <= at / limit < high] for low, high in ((0.2, 0.4), (0.8, np.inf))]
    return statistics.median(parts[1]) / statistics.median(parts[0]) - 1.0 if all(parts) else None


def summary(lines: Sequence[Line]) -> str:
    """Return the table."""
    return markdown_table(
        [
            {
                "answers": line["answers"],
                "wrong": len(line["wrong"]),
                "memory, first and last MB": f"{line['memory'][0][1]:.0f}, {line['memory'][-1][1]:.0f}",
                "growth %": None if line["growth"] is None else round(100 * line["growth"], 2),
                "threads, files, children before": " ".join(map(str, line["before"].values())),
                "after": " ".join(map(str, line["after"].values())),
            }
            for line in lines
            if line["memory"]
        ]
    )
