"""Worker processes (`octmip.trees.mip.highs.worker`): started when needed, used again, killed when they do not end.

A worker is started by the path of its file, never by importing the caller's script again, so this is as safe in
threads, in notebooks and on every system as a subprocess is. It costs some 0.2 s of CPU, mostly the import of numpy;
so one that has answered stays for `IDLE` seconds in case there is more to do, and is then closed and waited for. It
runs in a session of its own: Ctrl-C reaches the caller alone, who decides what becomes of the run.
"""

import atexit
import os
import queue
import subprocess
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any, BinaryIO

from octmip.errors import SolverError
from octmip.trees.mip.highs import worker

IDLE = 5.0  # seconds that a worker without work is kept for
MOST_IDLE = 2
MOST_BYTES = 300e6  # that a worker may hold to be used again: the memory of a large model is given back at once
START = 60.0  # seconds in which a worker must have started


class Worker:
    """A process that runs HiGHS, with threads that read and write its pipes, so that neither side ever waits on one."""

    def __init__(self) -> None:
        """Start the process.

        Raises
        ------
        SolverError
            there is no Python to start, or it cannot be.
        """
        if not sys.executable:
            raise SolverError(
                "sys.executable is empty; expected the path of Python, to run HiGHS in a process of its own; set it"
            )
        script = str(Path(worker.__file__).resolve())
        paths = [os.getcwd() if path == "" else path for path in sys.path]
        # A group of its own and no window, by the flags of each system.
        flags = getattr(subprocess, "CREATE_NEW_PROCESS_GROUP", 0) | getattr(subprocess, "CREATE_NO_WINDOW", 0)
        try:
            self.process = subprocess.Popen(
                [sys.executable, "-P", "-W", "ignore", script],
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=subprocess.DEVNULL,
                env={**os.environ, "PYTHONPATH": os.pathsep.join(paths)},
                start_new_session=not flags,
                creationflags=flags,
            )
        except OSError as error:
            raise SolverError(f"{sys.executable} cannot be started to run HiGHS: {error}") from error
        assert self.process.stdin is not None
        assert self.process.stdout is not None
        self.is_spent = False
        self._inbox: queue.SimpleQueue[Any] = queue.SimpleQueue()
        self._outbox: queue.SimpleQueue[Any] = queue.SimpleQueue()
        self._threads = [
            threading.Thread(target=self._read, args=(self.process.stdout,), daemon=True),
            threading.Thread(target=self._write, args=(self.process.stdin,), daemon=True),
        ]
        for thread in self._threads:
            thread.start()

    def _read(self, stream: BinaryIO) -> None:
        try:
            while (frame := worker.read_frame(stream)) is not None:
                self._inbox.put(frame)
        except OSError:  # killed in the middle of a frame: the same end
            pass
        self._inbox.put(("closed",))

    def _write(self, stream: BinaryIO) -> None:
        while (frame := self._outbox.get()) is not None:
            try:
                worker.write_frame(stream, frame)
            except OSError:  # the process has ended; `_read` says so
                return

    def send(self, *frame: Any) -> None:
        """Send a frame; returns at once."""
        self._outbox.put(frame)

    def receive(self, seconds: float) -> tuple[Any, ...] | None:
        """Return the next frame, ("closed",) when the process has ended, None when nothing comes within `seconds`."""
        try:
            frame: tuple[Any, ...] = self._inbox.get(timeout=seconds)
        except queue.Empty:
            return None
        return frame

    def close(self) -> None:
        """End the process and wait for it: nothing of it remains."""
        self.is_spent = True
        self._outbox.put(None)
        self.process.kill()
        self.process.wait()
        for thread in self._threads:
            thread.join()
        for stream in (self.process.stdin, self.process.stdout):
            assert stream is not None
            with suppress(OSError):  # what was still to be written to the ended process
                stream.close()


def resident_bytes(pid: int) -> float:
    """Return the memory that a process holds, 0 where the system does not report it (no limit is kept there)."""
    try:
        return float(int(Path(f"/proc/{pid}/statm").read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE"))
    except (OSError, IndexError):
        return 0.0


_idle: list[tuple[Worker, threading.Timer]] = []
_lock = threading.Lock()


@contextmanager
def lent_worker() -> Iterator[Worker]:
    """Lend a worker that is started or starting; it is closed afterwards if it is spent, else kept for a while.

    Raises
    ------
    SolverError
        no process can be started.
    """
    lent = _taken() or Worker()
    try:
        yield lent
    except BaseException:
        lent.close()
        raise
    if not lent.is_spent and resident_bytes(lent.process.pid) < MOST_BYTES:
        _keep(lent)
    elif not lent.is_spent:
        lent.close()


def warm() -> None:
    """Start a worker if none waits, so that it is ready when it is needed."""
    with _lock:
        is_warm = bool(_idle)
    if not is_warm:
        _keep(Worker())


def _taken() -> Worker | None:
    while True:
        with _lock:
            if not _idle:
                return None
            found, timer = _idle.pop()
        timer.cancel()
        if found.process.poll() is None:
            return found
        found.close()


def _keep(spare: Worker) -> None:
    timer = threading.Timer(IDLE, _expire, [spare])
    timer.daemon = True
    with _lock:
        is_kept = len(_idle) < MOST_IDLE
        if is_kept:
            _idle.append((spare, timer))
    if is_kept:
        timer.start()
    else:
        spare.close()


def _expire(spare: Worker) -> None:
    with _lock:
        entry = next((entry for entry in _idle if entry[0] is spare), None)
        if entry is None:  # lent again meanwhile
            return
        _idle.remove(entry)
    spare.close()


def close_idle() -> None:
    """Close every worker that waits for work."""
    while (spare := _taken()) is not None:
        spare.close()


def _forget() -> None:
    """Forget the workers in a forked copy of this process: they belong to the original."""
    global _lock
    _lock = threading.Lock()
    for spare, _ in _idle:
        spare.process.returncode = 0
    _idle.clear()


atexit.register(close_idle)
if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_forget)
