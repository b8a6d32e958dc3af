"""One row of the table of doors: an input that another program wrote, the door it is given to, and the right answer."""

import contextlib
import io
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from octmip.errors import DataError
from octmip.interfaces.cli import main


@dataclass(frozen=True)
class Refused:
    """The right answer is one sentence that refuses the input.

    Attributes
    ----------
    words : what the sentence must hold, each of them: the place, what was got, the cure.
    """

    words: tuple[str, ...]


@dataclass(frozen=True)
class Row:
    """An input of another program at one door.

    Attributes
    ----------
    door : the door, by the name that docs/reliability.md gives it, such as "octmip solve TABLE".
    writer : the program that wrote the input and its version, such as "gmsh 4.15"; "R 4.3, kept" for a file kept here.
    case : what is special about the input.
    make : writes the input into a folder, with the writer itself or as its kept bytes, and returns it. It calls
        `pytest.importorskip` for a writer that may be absent.
    ask : gives the input to the door and returns the answer, in a form that compares with `==`.
    answer : the right answer, from a definition that shares nothing with the door, or `Refused`. A function is called
        with the input.
    """

    door: str
    writer: str
    case: str
    make: Callable[[Path], Any]
    ask: Callable[[Any], Any]
    answer: Any

    def __str__(self) -> str:
        """Return the name of the row in a report of tests."""
        return f"{self.door} | {self.writer} | {self.case}"


def command(*words: object) -> str:
    """Run the octmip command in this process and return what it printed; raise its refusal.

    Raises
    ------
    DataError
        With what it wrote to standard error, where it ended with exit code 2.
    """
    out, err = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        code = main([str(word) for word in words])
    if code == 2:
        raise DataError(err.getvalue().strip())
    assert code == 0, f"exit code {code}: {err.getvalue()}"
    return out.getvalue()
