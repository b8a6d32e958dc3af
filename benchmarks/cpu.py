"""CPU seconds of this process and its children, and a limit in them: on a busy machine the clock says little."""

import multiprocessing
import os
import resource
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypedDict

from octmip.trees.answer.solution import Limits, Progress


class Supervision(TypedDict):
    """Arguments by which any solver is watched and stopped."""

    limits: Limits
    progress: Callable[[Progress], None]


def cpu_limit(seconds: float) -> Supervision:
    """Return the arguments that stop a form after so many CPU seconds, and at last by the clock."""
    before = cpu_seconds()

    def watch(_: Progress) -> None:
        if cpu_seconds() - before > seconds:
            raise KeyboardInterrupt

    return {"limits": Limits(seconds=50 * seconds), "progress": watch}


def cpu_seconds() -> float:
    """Return user and system seconds of this process, all threads, and of its children: HiGHS runs in one."""
    used = [resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)]
    return sum(usage.ru_utime + usage.ru_stime for usage in used) + _seconds_of_running_children()


def within(seconds: float, work: Callable[[], Any]) -> Any:
    """Return what `work` returns in a fork of this process, None where it is killed after so many CPU seconds."""
    fork = multiprocessing.get_context("fork")
    receive, send = fork.Pipe(duplex=False)
    child = fork.Process(target=lambda: send.send(work()))
    child.start()
    send.close()
    while not receive.poll(0.05):
        if _seconds_of(str(child.pid)) > seconds:
            child.kill()
            break
    try:
        return receive.recv()
    except EOFError:
        return None
    finally:
        child.join()


def _seconds_of_running_children() -> float:
    """Return the CPU seconds of the children that still run, by Linux's /proc; 0 elsewhere."""
    threads = Path("/proc/self/task").glob("*/children")
    return sum(_seconds_of(child) for thread in threads for child in _read(thread).split())


def _seconds_of(process: str) -> float:
    fields = _read(Path(f"/proc/{process}/stat")).rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK") if fields else 0.0


def _read(path: Path) -> str:
    """Return the text of a file of /proc, none where its thread or process has ended since."""
    try:
        return path.read_text()
    except (FileNotFoundError, ProcessLookupError):
        return ""


class Stopwatch:
    """Counts CPU and wall seconds from the moment it is made."""

    def __init__(self) -> None:
        self._cpu, self._wall = cpu_seconds(), time.perf_counter()

    def read(self) -> tuple[float, float]:
        """Return CPU and wall seconds since the beginning."""
        return cpu_seconds() - self._cpu, time.perf_counter() - self._wall
