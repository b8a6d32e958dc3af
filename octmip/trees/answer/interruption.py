"""Interruption: Ctrl-C, and SIGTERM in a command, end a call as a whole, however many searches it makes.

Python raises one `KeyboardInterrupt` for a signal, and the search that runs takes it and returns its best tree. So
whoever takes it notes it here, and whatever follows in the same call asks: the next solve returns at once with what is
known, a poll of the native core in another thread ends its search.

Signals are counted and the count is never set back: a call is interrupted when one was heard since it began.
"""

import contextlib
import threading
from collections.abc import Iterator
from contextvars import ContextVar

_heard = 0
_held_back = 0
_lock = threading.Lock()
_begun: ContextVar[int | None] = ContextVar("begun", default=None)


@contextlib.contextmanager
def whole_call() -> Iterator[None]:
    """Make what runs inside one call; inside another one it is a part of that."""
    if _begun.get() is not None:
        yield
        return
    token = _begun.set(_heard)
    try:
        yield
    finally:
        _begun.reset(token)


def note() -> None:
    """Note that a signal was heard: the calls that run now are interrupted."""
    global _heard
    with _lock:
        _heard += 1


def is_heard() -> bool:
    """Whether the call that runs here was interrupted."""
    begun = _begun.get()
    return begun is not None and _heard > begun


@contextlib.contextmanager
def held_back() -> Iterator[None]:
    """Let a command show and write what it found: the first signal is noted inside, and raises nothing."""
    global _held_back
    _held_back += 1
    try:
        yield
    finally:
        _held_back -= 1


def is_held_back() -> bool:
    """Whether a first signal is to raise nothing now."""
    return _held_back > 0
