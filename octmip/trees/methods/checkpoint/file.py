"""Checkpoint files: entries of what was asked and what was found.

Line 1 names the format and the version of octmip. Every other line is one entry: the sha256 of its rest, then what was
asked and what was found, two JSON objects without blanks. The file is written whole or not at all, so of a run that was
killed its last whole file stands. The sums find accidents, not forgers: trees are certified again, bounds are believed.
"""

import contextlib
import hashlib
import importlib
import json
import os
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from octmip.errors import DataError, WriteError
from octmip.input.files import PathLike, check_writable, keep_bytes, read_bytes, warn_not_kept

FORMAT = "octmip-checkpoint 6"
MEANING = {
    "data": "samples, labels and weights",
    "question": "depth, costs, limits and sensors",
    "method": "method",
    "options": "options of the method",
    "seed": "seed",
    "solve": "limits and start of one solve of a study",
}
"""What an entry says of what was asked."""

Asked = Mapping[str, str]


@dataclass(frozen=True, slots=True)
class CheckpointFile:
    """A file of one entry, or of the entries of a study.

    Attributes
    ----------
    path
        of the file.
    is_study
        whether it holds many entries, to which others are added; else one, and another question is refused.
    """

    path: PathLike
    is_study: bool

    def find(self, asked: Asked) -> dict[str, Any]:
        """Return what was found of a question; nothing without an entry.

        Raises
        ------
        DataError
            the file cannot be read or written, is damaged, or belongs to another version or, of one entry, another
            question.
        """
        check_writable(self.path)
        entries = self._entries()
        line = entries.get(_words(asked))
        if line is None and entries and not self.is_study:
            raise self._foreign(asked, next(iter(entries)))
        try:
            return {} if line is None else dict(json.loads(line))
        except (ValueError, TypeError, RecursionError) as error:
            raise self.unusable(f"holds something else than was found ({error!r})") from error

    def keep(self, asked: Asked, found: Mapping[str, Any]) -> None:
        """Put what was found of a question in place of what was there; where that fails, warn: the work goes on."""
        line = json.dumps(found, separators=(",", ":")).encode()
        with _alone(self.path):
            try:
                entries = self._entries()  # other processes of a study may have added theirs
            except DataError as error:
                warn_not_kept(WriteError(str(error)))
                return
            lines = [summed(words + b" " + entry) for words, entry in (entries | {_words(asked): line}).items()]
            keep_bytes(self.path, b"\n".join([first_line(), *lines, b""]))

    def unusable(self, reason: str) -> DataError:
        """Return the error of a file from which nothing can go on."""
        return DataError(f"checkpoint {self.path} {reason}; give another file, or remove this one to begin again")

    def _entries(self) -> dict[bytes, bytes]:
        if not Path(self.path).exists():
            return {}
        first, *lines = read_bytes(self.path).split(b"\n")
        if first != first_line():
            got = first[:60].decode("ascii", "replace")
            raise self.unusable(
                f"is none of this version of octmip: line 1 is {got!r}; expected {first_line().decode()!r}"
            )
        found = {}
        for number, line in enumerate(lines, start=2):
            rest = line.partition(b" ")[2]
            if (number < len(lines) + 1) != bool(line) or (line and line != summed(rest)):
                raise self.unusable(f"is damaged: line {number} does not have the sum of its rest")
            if line:
                words, _, entry = rest.partition(b" ")
                found[words] = entry
        return found

    def _foreign(self, asked: Asked, words: bytes) -> DataError:
        """Return the error of a file of another question, which names what is another one."""
        try:
            got = dict(json.loads(words))
        except (ValueError, TypeError) as error:
            return self.unusable(f"names no question ({error!r})")
        name = next((name for name in MEANING if got.get(name) != asked.get(name)), "question")
        has = f"other {MEANING[name]}"
        if name in ("method", "seed"):  # the others are sums, which tell a reader nothing
            has = f"the {MEANING[name]} {got.get(name)!r}; expected {asked.get(name)!r}"
        return self.unusable(f"belongs to another search: it has {has}")


@contextlib.contextmanager
def _alone(path: PathLike) -> Iterator[None]:
    """Let no other process that does the same write a file of this folder, where the system can see to that."""
    folder = None
    with contextlib.suppress(ImportError, OSError):
        import fcntl  # of Unix alone; file systems of a network may know no locks

        folder = os.open(Path(os.path.realpath(path)).parent, os.O_RDONLY)
        fcntl.flock(folder, fcntl.LOCK_EX)
    try:
        yield
    finally:
        if folder is not None:
            os.close(folder)


def first_line() -> bytes:
    """Return line 1: format and version."""
    version = importlib.import_module("octmip.trees._native").__version__  # only here: the package begins without it
    return f"{FORMAT} {version}".encode()


def _words(asked: Asked) -> bytes:
    return json.dumps(asked, separators=(",", ":")).encode()


def summed(rest: bytes) -> bytes:
    """Return the line of an entry: the sum of its rest, and that."""
    return hashlib.sha256(rest).hexdigest().encode() + b" " + rest
