"""CPU seconds of this process, and a limit in them: on a busy machine the clock says little of the work done."""

import resource
import time
from collections.abc import Callable
from typing import TypedDict

from octmip.solution import Limits, Progress


class Supervision(TypedDict):
    """Arguments by which any solver is watched and stopped."""

    limits: Limits
    progress: Callable[[Progress], None]


def cpu_limit(seconds: float) -> Supervision:
    """Return the arguments that stop a form after so many CPU seconds of this process, and at last by the clock."""
    before = cpu_seconds()

    def watch(_: Progress) -> None:
        if cpu_seconds() - before > seconds:
            raise KeyboardInterrupt

    return {"limits": Limits(seconds=50 * seconds), "progress": watch}


def cpu_seconds() -> float:
    """Return user and system seconds of this process, all threads."""
    usage = resource.getrusage(resource.RUSAGE_SELF)
    return usage.ru_utime + usage.ru_stime


class Stopwatch:
    """Counts CPU and wall seconds from the moment it is made."""

    def __init__(self) -> None:
        self._cpu, self._wall = cpu_seconds(), time.perf_counter()

    def read(self) -> tuple[float, float]:
        """Return CPU and wall seconds since the beginning."""
        return cpu_seconds() - self._cpu, time.perf_counter() - self._wall
