"""A reader of files under test, and a command run in this process.

A reader's `make` writes small valid files by the project's own writers; `target` is the one that is mangled. `read`
reads it and then uses what was read, because what is accepted must be harmless.
"""

import contextlib
import io
import tempfile
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

from benchmarks.readers.mangling import Generator, Mangler
from octmip.errors import OctmipError
from octmip.interfaces.cli import main

Files = dict[str, bytes]


class CommandError(Exception):
    """A command that broke its own rules: another exit code, no line or several, a line that a terminal obeys."""


class RefusedError(OctmipError):
    """A command that refused its input, as it should."""


@dataclass(frozen=True, slots=True)
class Reader:
    """A reader under test.

    Attributes
    ----------
    make
        writes valid files into a folder, others for every number.
    target
        name of the one that is mangled.
    mangle
        the way to change one that knows its form.
    read
        reads the first file in a folder and uses what it holds.
    n_made
        different valid files.
    """

    make: Callable[[int, Path], None]
    target: str
    mangle: Mangler
    read: Callable[[Generator, Path], object]
    n_made: int = 4
    kept: dict[int, Files] = field(default_factory=dict, compare=False)

    def files(self, number: int) -> Files:
        """Return the valid files of a number, made once."""
        if number not in self.kept:
            with tempfile.TemporaryDirectory() as folder:
                self.make(number, Path(folder))
                self.kept[number] = {path.name: path.read_bytes() for path in sorted(Path(folder).iterdir())}
        return self.kept[number]


def run(*words: object) -> None:
    """Run a command in this process; refuse as it refuses, and complain where it does neither that nor its work."""
    raw = io.BytesIO()
    out, err = io.TextIOWrapper(io.BytesIO(), "utf-8"), io.TextIOWrapper(raw, "utf-8")
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        code = main([str(word) for word in words])
    err.flush()
    said = raw.getvalue().decode()
    if code not in (0, 1, 2) or (code and said.count("\n") != 1) or "standard output cannot" in said:
        raise CommandError(f"{words[0]} ended with {code} and said {said[:300]!r}")
    if code and (not said.startswith("octmip") or not said[:-1].isprintable() or len(said) > 10_200):
        raise CommandError(f"{words[0]} said {said[:300]!r}")
    if code:
        raise RefusedError(said)
