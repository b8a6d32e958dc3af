"""The `octmip` command: `program` runs it; here is what has to stand before anything else is imported.

A signal that Python raises while it loads a package comes out of that as any error, so until `program` hears signals
each ends the command at once.
"""

import _signal  # type: ignore[import-not-found]  # `signal` takes as long to import as Python to start
import atexit
import os

TYPE_CHECKING = False  # as `typing` has it, whose import takes longer than all else here
if TYPE_CHECKING:
    from collections.abc import Sequence
    from types import FrameType


def main(words: "Sequence[str] | None" = None) -> int:
    """Run one command and return its exit code; without words, those of the command line, as a program."""
    ended: list[int] = []
    if words is None:
        for number in (_signal.SIGINT, _signal.SIGTERM):  # first of all: a signal before is a traceback
            _signal.signal(number, _end)
        # A thread of OpenBLAS takes tens of megabytes of address space and spins for ever where it gets none; numexpr,
        # which pandas loads where it is installed, ends the process.
        for threads in ("OPENBLAS_NUM_THREADS", "NUMEXPR_NUM_THREADS"):
            os.environ.setdefault(threads, "1")
        atexit.register(_leave, ended)  # the first that is registered is called last
    from octmip.interfaces.cli import program

    ended.append(program.run_words(words))
    return ended[0]


def _leave(ended: list[int]) -> None:
    """Leave a program that is done: behind this Python takes down its handlers, and a signal would change the code."""
    from octmip.interfaces.cli.stages import leave

    if ended:
        leave(ended[0])


def _end(number: int, frame: "FrameType | None") -> None:
    """End the program: nothing is known yet."""
    os.write(2, b"octmip: terminated\n" if number == _signal.SIGTERM else b"octmip: interrupted\n")
    os._exit(128 + number)
