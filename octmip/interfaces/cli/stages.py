"""How a command ends by a signal, within a second whatever is being computed, and the stages of a long one.

SIGTERM, which batch systems and service managers send before they kill, is heard as Ctrl-C. One mechanism:

handler     notes the signal (`octmip.trees.answer.interruption`) and raises KeyboardInterrupt; the solve that runs
            takes it and returns its best tree and bound, those behind it in the same command return at once, and the
            command shows and writes what is known. Between solves KeyboardInterrupt ends the command itself
held back   while a result is shown and written a first signal is noted alone
watch       a thread: Python hears a signal only between two of its own instructions, and a factorisation or the reading
            of a table may take longer than anybody waits. Such a command is ended without its result
"""

import contextlib
import math
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
from typing import NoReturn

from octmip.input.names import visible
from octmip.trees.answer import interruption

INTERRUPTED, TERMINATED = 130, 143
"""Exit codes of a program that ended by SIGINT and by SIGTERM without a result: 128 and the number of the signal."""
TICK = 0.5
"""Seconds between two lines of progress."""
PATIENCE = 0.5
"""Seconds after a signal in which Python has to hear it, and what is shown has to be taken by its reader."""
LONGEST_END = 10.0
"""Seconds after a signal in which a result has to be shown and written."""
AGAIN = 0.02
"""Seconds after which a signal is sent again that was lost."""
IMPORT = 0.25
"""Seconds after a signal in which an import may end: compiled modules drop what is raised while they are loaded."""
SIGNALS = (signal.SIGINT, signal.SIGTERM)
MOST_TOLD = 64
"""Signals that are taken as one: they came while the watch was waiting."""


def leave(code: int) -> NoReturn:
    """End the program now: to take down all that was imported needs longer than a search needs to end."""
    for stream in (sys.stdout, sys.stderr):
        with contextlib.suppress(OSError, ValueError):  # its reader is gone, or it is closed
            stream.flush()
    os._exit(code)


class Heard:
    """The signals that were heard.

    Attributes
    ----------
    n_signals
        their number.
    is_termination
        whether the last one was SIGTERM.
    is_held_back
        whether the only one so far raised nothing.
    raises
        whether a signal raises `KeyboardInterrupt`; else it is noted alone.
    code
        exit code of a program that is done: a later signal ends it with that; None before.
    """

    def __init__(self) -> None:
        self.n_signals = 0
        self.is_termination = False
        self.is_held_back = False
        self.raises = True
        self.code: int | None = None
        self._in_import = math.inf  # when a signal first came in one
        self._is_again = False
        self._timer: threading.Timer | None = None

    @property
    def word(self) -> str:
        """The last word of a command that was interrupted without a result."""
        return "terminated" if self.is_termination else "interrupted"

    @property
    def exit_code(self) -> int:
        """The exit code of a command that was interrupted without a result."""
        return TERMINATED if self.is_termination else INTERRUPTED

    def begin(self) -> None:
        """Let signals raise from now on; raise for one that came before."""
        self.raises = True
        if self.n_signals:
            raise KeyboardInterrupt

    def hear(self, number: int, frame: FrameType | None) -> None:
        """Note a signal and raise `KeyboardInterrupt`; a first one is noted alone where it is held back.

        In an import it waits, as what is raised there may be lost; in a long one it is raised until it is not.
        """
        if self.code is not None:
            os._exit(self.code)
        is_again, self._is_again = self._is_again, False
        if self.raises and not interruption.is_held_back() and _imports(frame):
            self._in_import = min(self._in_import, time.monotonic())
            self._send_again(number)
            if time.monotonic() < self._in_import + IMPORT:
                return
        elif is_again and self.n_signals:
            return
        self.n_signals += 1
        self.is_termination = number == signal.SIGTERM
        self.is_held_back = not self.raises or (self.n_signals == 1 and interruption.is_held_back())
        interruption.note()
        if not self.is_held_back:
            raise KeyboardInterrupt

    def hear_again(self, lost: "sys.UnraisableHookArgs") -> None:
        """Send the signal again where what it raised was lost: Python drops it in a finaliser, as imports have many."""
        if not issubclass(lost.exc_type, KeyboardInterrupt):
            sys.__unraisablehook__(lost)
            return
        self.n_signals = 0
        self._send_again(signal.SIGTERM if self.is_termination else signal.SIGINT)  # raised here it would be lost too

    def _send_again(self, number: int) -> None:
        self.stop_sending()
        self._timer = threading.Timer(AGAIN, self._sent_again, (number,))
        self._timer.start()

    def _sent_again(self, number: int) -> None:
        self._is_again = True
        os.kill(os.getpid(), number)

    def stop_sending(self) -> None:
        """Send no signal again."""
        if self._timer is not None:
            self._timer.cancel()


def _imports(frame: FrameType | None) -> bool:
    """Whether a module is being loaded."""
    while frame is not None and not frame.f_code.co_filename.startswith("<frozen importlib"):
        frame = frame.f_back
    return frame is not None


@contextlib.contextmanager
def term_as_interrupt(*, raises: bool = True) -> Iterator[Heard]:
    """Raise `KeyboardInterrupt` on SIGINT and SIGTERM inside, one call as a whole; yields what was heard.

    With `raises` False they are noted alone, until `Heard.begin`.

    The handlers of before are put back, but where `Heard.code` says that the program is done.
    """
    heard = Heard()
    heard.raises = raises
    if threading.current_thread() is not threading.main_thread():  # only there does Python hear signals
        yield heard
        return
    before, hook = [signal.signal(number, heard.hear) for number in SIGNALS], sys.unraisablehook
    sys.unraisablehook = heard.hear_again
    try:
        with interruption.whole_call():
            yield heard
    finally:
        heard.stop_sending()
        sys.unraisablehook = hook
        if heard.code is None:
            for number, handler in zip(SIGNALS, before, strict=True):
                signal.signal(number, handler)


class Watch:
    """A thread that ends the program where it does not end by itself soon after a signal."""

    def __init__(self, heard: Heard) -> None:
        self._heard = heard
        self._done = threading.Event()
        self._thread = threading.Thread(target=self._watch, daemon=True)
        self._is_main = threading.current_thread() is threading.main_thread()

    def __enter__(self) -> "Watch":
        if self._is_main:  # only there does Python hear signals
            self._told, self._ear = socket.socketpair()
            self._told.setblocking(False)
            self._before = signal.set_wakeup_fd(self._told.fileno(), warn_on_full_buffer=False)
            self._thread.start()
        return self

    def _watch(self) -> None:
        n_before, last = 0, math.inf
        while True:
            left = None if math.isinf(last) else max(0.0, last - time.monotonic())
            told = self._ear.recv(MOST_TOLD) if select.select([self._ear], [], [], left)[0] else b""
            if self._done.is_set():
                return
            last = min(last, time.monotonic() + LONGEST_END)
            if not told and interruption.is_held_back():  # a slow disk
                last = math.inf
            elif not told:
                self._end()
            elif self._done.wait(PATIENCE):
                return
            elif self._heard.n_signals == n_before:
                self._heard.is_termination = told[-1] == signal.SIGTERM
                self._end()
            elif self._heard.is_held_back:  # nobody takes what is shown
                os.kill(os.getpid(), told[-1])
            n_before = self._heard.n_signals

    def _end(self) -> NoReturn:
        """End the program as an interrupt does, without waiting for the computation."""
        clear = "\r\x1b[2K" if sys.stderr.isatty() else ""
        print(f"{clear}octmip: {self._heard.word}", file=sys.stderr, flush=True)
        os._exit(self._heard.exit_code)

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        if not self._is_main:
            return
        self._done.set()
        signal.set_wakeup_fd(self._before)
        self._told.send(b"\0")  # the thread wakes and ends
        self._thread.join()
        self._told.close()
        self._ear.close()


class StageLine:
    """One line on a terminal that says what a command is doing, and for how long; nothing where there is no terminal.

    A thread of its own writes it: one stage may take many seconds.

    Parameters
    ----------
    stage
        the first one.
    expected
        a line above it, such as how long it may take.
    """

    def __init__(self, stage: str, expected: str = "") -> None:
        self._stage, self._expected = stage, expected
        self._is_terminal = sys.stderr.isatty()
        self._start = time.monotonic()
        self._done = threading.Event()
        self._thread = threading.Thread(target=self._repeat, daemon=True)

    def __enter__(self) -> "StageLine":
        if self._is_terminal:
            if self._expected:
                print(self._expected, file=sys.stderr, flush=True)
            self._thread.start()
        return self

    def __call__(self, stage: object) -> None:
        """Show a stage."""
        self._stage = visible(stage)
        self._show()

    def _repeat(self) -> None:
        while not self._done.wait(TICK):
            self._show()

    def _show(self) -> None:
        if self._is_terminal:
            room = max(20, shutil.get_terminal_size().columns - 1)
            line = f"{time.monotonic() - self._start:4.0f} s  {self._stage} ..."
            print(f"\r\x1b[2K{line[:room]}", end="", file=sys.stderr, flush=True)

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        self._done.set()
        if self._is_terminal:
            self._thread.join()
            print("\r\x1b[2K", end="", file=sys.stderr, flush=True)
