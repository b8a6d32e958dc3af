"""Half an hour of mixed problems in one process: memory flat, no thread, file or child left, no answer wrong.

`python -m benchmarks.run soak --limit 1800`. The questions are those of `fuzz_everything`, of every kind and solver,
one seed after the other. Resident memory is read after each hundred of them, garbage collected before; the first fifth
of the time is warm-up (allocator, imports, caches of fixed size). Flat is: the median of the last fifth at most 5 %
above that of the second fifth.
"""

import gc
import itertools
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

EVERY, AGAIN = 100, 10
"""Questions between two readings of memory, and how often each is asked: enumeration takes longer than an answer."""


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
    """Yield one line: answers by kind, memory over time, what was there after the first seeds and is at the end."""
    asked = itertools.chain.from_iterable(questions(seed) for seed in itertools.count())
    for entry in itertools.islice(asked, EVERY):
        answer(*entry)
    start, first, counts, wrong = time.monotonic(), left(), Counter[str](), list[str]()
    memory: list[tuple[float, float]] = []
    while time.monotonic() - start < limit:
        for question, problem, truth in itertools.islice(asked, EVERY):
            counts[f"{question.kind} {question.method}"] += AGAIN
            said = [answer(question, problem, truth)["wrong"] for _ in range(AGAIN)]
            wrong += [f"{question}: {one}" for one in said if one]
        memory.append((time.monotonic() - start, resident()))
    yield {"size": "mixed problems", "seed": STREAM, "problems": counts.total(), "counts": counts, "memory": memory} | {
        "growth": growth(memory, limit),
        "before": first,
        "after": left(),
        "wrong": wrong,
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
                "answers": line["problems"],
                "memory, first and last MB": f"{line['memory'][0][1]:.0f}, {line['memory'][-1][1]:.0f}",
                "growth %": None if line["growth"] is None else round(100 * line["growth"], 2),
                "threads, files, children before": " ".join(map(str, line["before"].values())),
                "after": " ".join(map(str, line["after"].values())),
                "wrong": len(line["wrong"]),
            }
            for line in lines
        ]
    )
