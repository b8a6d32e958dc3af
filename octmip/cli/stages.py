"""Stages of a long command on a terminal, and signals that are heard within a second whatever is being computed.

SIGTERM, which batch systems and service managers send before they kill, is heard as Ctrl-C: a search returns its best
tree and bound, which the command shows and writes.
"""

import contextlib
import os
import select
import shutil
import signal
import socket
import sys
import threading
import time
from collections.abc import Iterator
from types import FrameType, TracebackType

from octmip.formats.names import visible

INTERRUPTED, TERMINATED = 130, 143
"""Exit codes of a program that ended by SIGINT and by SIGTERM without a result: 128 and the number of the signal."""
TICK = 0.5
"""Seconds between two lines of progress."""
PATIENCE = 0.5
"""Seconds after Ctrl-C that the computation has to end by itself. One factorisation of a fine mesh takes several, and
Python hears a signal only between two of its own instructions."""
ENDS = {
    bytes([signal.SIGINT]): ("interrupted", INTERRUPTED),
    bytes([signal.SIGTERM]): ("terminated", TERMINATED),
}
"""The last word and the exit code, by the signal that ends a program."""


class StageLine:
    """One line on a terminal that says what a command is doing, and for how long; nothing where there is no terminal.

    A thread of its own writes it: one stage may take many seconds. The same thread hears of Ctrl-C at once and ends the
    program where the computation does not do so itself; nothing is written to files meanwhile.
    """

    def __init__(self, expected: str) -> None:
        self._expected = expected
        self._is_terminal = sys.stderr.isatty()
        self._stage = ""
        self._start = time.monotonic()
        self._done = threading.Event()
        self._thread = threading.Thread(target=self._watch, daemon=True)
        self._told, self._ear = socket.socketpair()
        self._told.setblocking(False)
        self._is_main = threading.current_thread() is threading.main_thread()
        self._before = -1

    def __enter__(self) -> "StageLine":
        if self._is_terminal:
            print(self._expected, file=sys.stderr, flush=True)
        if self._is_main:  # only there does Python hear signals
            self._before = signal.set_wakeup_fd(self._told.fileno(), warn_on_full_buffer=False)
        self._thread.start()
        return self

    def __call__(self, stage: object) -> None:
        """Show a stage."""
        self._stage = visible(stage)
        self._show()

    def _watch(self) -> None:
        while not self._done.is_set():
            if select.select([self._ear], [], [], TICK)[0]:
                heard = self._ear.recv(1)
                if heard in ENDS and not self._done.wait(PATIENCE):
                    self._end(*ENDS[heard])
            elif not self._done.is_set():
                self._show()

    def _show(self) -> None:
        if self._is_terminal:
            room = max(20, shutil.get_terminal_size().columns - 1)
            line = f"{time.monotonic() - self._start:4.0f} s  {self._stage} ..."
            print(f"\r\x1b[2K{line[:room]}", end="", file=sys.stderr, flush=True)

    def _clear(self) -> None:
        if self._is_terminal:
            print("\r\x1b[2K", end="", file=sys.stderr, flush=True)

    def _end(self, word: str, code: int) -> None:
        """End the program as an interrupt does, without waiting for the computation."""
        self._clear()
        print(f"octmip: {word}", file=sys.stderr, flush=True)
        os._exit(code)

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        self._done.set()
        if self._is_main:
            signal.set_wakeup_fd(self._before)
        self._told.send(b"\0")  # the thread wakes and ends
        self._thread.join()
        self._told.close()
        self._ear.close()
        self._clear()


class Heard:
    """Whether SIGTERM was heard."""

    def __init__(self) -> None:
        self.is_termination = False

    @property
    def exit_code(self) -> int:
        """The exit code of a command that was interrupted without a result."""
        return TERMINATED if self.is_termination else INTERRUPTED


@contextlib.contextmanager
def term_as_interrupt() -> Iterator[Heard]:
    """Raise `KeyboardInterrupt` on SIGTERM, too, inside; yields what was heard. Only the main thread can do so."""
    heard = Heard()
    if threading.current_thread() is not threading.main_thread():  # only there does Python hear signals
        yield heard
        return

    def interrupt(number: int, frame: FrameType | None) -> None:
        heard.is_termination = True
        raise KeyboardInterrupt

    before = signal.signal(signal.SIGTERM, interrupt)
    try:
        yield heard
    finally:
        signal.signal(signal.SIGTERM, before)
