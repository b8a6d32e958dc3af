"""SIGTERM heard as Ctrl-C: what batch systems and service managers send before they kill.

A search that hears of it returns its best tree and bound, which the command shows and writes, as after Ctrl-C.
"""

import contextlib
import signal
import threading
from collections.abc import Iterator
from types import FrameType

INTERRUPTED, TERMINATED = 130, 143
"""Exit codes of a program that ended by SIGINT and by SIGTERM without a result: 128 and the number of the signal."""


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
