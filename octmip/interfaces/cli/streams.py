"""Standard output and standard error of the program as they may be found: closed, or on a disk that is full.

What a command found is written to its files first, and what cannot be shown is one sentence with exit code 1. Standard
error holds words alone: where nobody can read them the command goes on.
"""

import contextlib
import io
import os
import sys
from collections.abc import Iterator


class Unheard(io.FileIO):
    """A stream of words whose failures are nobody's: it is closed, its disk is full, or its reader is gone."""

    def write(self, words: object) -> int:
        """Write what can be written, and say that all was."""
        try:
            return super().write(words)  # type: ignore[arg-type]
        except OSError:
            return len(memoryview(words))  # type: ignore[arg-type]


def open_streams() -> None:
    """Open the streams that are closed, and let standard error fail in silence.

    A file that is opened while descriptor 1 or 2 is free would take its place, and receive whatever is shown. What
    takes it here can only be read, so that writing fails as on any stream that does not take what it is given.
    """
    for descriptor in (0, 1, 2):
        try:
            os.fstat(descriptor)
        except OSError:
            os.open(os.devnull, os.O_RDONLY)  # the lowest that is free: this one
    if sys.stdout is None:
        sys.stdout = open(1, "w", encoding="utf-8", closefd=False)  # noqa: SIM115 it stays open to the end
    sys.stderr = io.TextIOWrapper(
        io.BufferedWriter(Unheard(2, "w", closefd=False)),
        encoding=getattr(sys.stderr, "encoding", "utf-8"),
        errors="backslashreplace",
        line_buffering=True,
    )


@contextlib.contextmanager
def prints_aside() -> Iterator[None]:
    """Send to standard error whatever a model prints, programs that it starts too: standard output is the answer's."""
    sys.stdout.flush()
    with contextlib.ExitStack() as stack:
        stack.enter_context(contextlib.redirect_stdout(sys.stderr))
        with contextlib.suppress(OSError):  # a process that has no such streams, beneath those of Python
            kept = os.dup(1)
            stack.callback(os.close, kept)
            stack.callback(os.dup2, kept, 1)
            os.dup2(2, 1)
        yield
