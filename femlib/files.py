"""Files that appear whole or not at all, and reading whose failure is one sentence."""

import json
import os
import secrets
import stat
from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager
from importlib import import_module
from pathlib import Path
from typing import Any, BinaryIO

from femlib.errors import InputError

MOST_BYTES = 2**32
"""Size of a file that is read whole: beyond it memory ends before a sentence can be said."""
MOST_LEVELS = 100
"""Levels of lists and objects in a JSON file."""
_DEEP = f"nested deeper than {MOST_LEVELS} levels"


@contextmanager
def whole_file(target: Path) -> Iterator[Path]:
    """Give a temporary file beside `target` to fill, then rename it; if that fails, nothing is left.

    It has the permissions of the file that it replaces.

    Raises
    ------
    InputError
        If the target is a folder or its folder cannot be written to.
    """
    if target.is_dir():
        raise InputError(f"{target} cannot be written (it is a folder); expected a file; add a name to it")
    temporary = target.with_name(f".{target.stem}.{secrets.token_hex(4)}{target.suffix}")
    mode = stat.S_IMODE(target.stat().st_mode) if target.exists() else None
    try:
        temporary.touch(mode=0o666 if mode is None else mode | stat.S_IWUSR, exist_ok=False)
    except OSError as error:
        raise InputError(
            f"{target} cannot be written ({error.strerror}); expected a writable folder; create it"
        ) from error
    try:
        yield temporary
        if mode is not None:
            temporary.chmod(mode)
        os.replace(temporary, target)
    finally:
        temporary.unlink(missing_ok=True)


@contextmanager
def limited_memory(room: int) -> Iterator[None]:
    """Let the process take `room` more bytes of memory, then raise `MemoryError`; no limit where none can be set."""
    try:
        resource = import_module("resource")  # not on Windows
        taken = int(Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize()  # only on Linux
        before, hard = resource.getrlimit(resource.RLIMIT_AS)
    except (ImportError, OSError):
        yield
        return
    known = [limit for limit in (taken + room, before, hard) if limit != resource.RLIM_INFINITY]
    resource.setrlimit(resource.RLIMIT_AS, (min(known), hard))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_AS, (before, hard))


@contextmanager
def regular_file(path: Path, expected: str) -> Iterator[BinaryIO]:
    """Open a regular file to be read; nothing is waited for, as a pipe would.

    Raises
    ------
    InputError
        If it is missing, cannot be read, or is a folder, pipe or device; `expected` says what it should be.
    """
    try:
        # Without O_NONBLOCK a pipe that nobody writes to blocks the opening for ever.
        descriptor = os.open(path, os.O_RDONLY | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_BINARY", 0))
    except (OSError, ValueError) as error:
        reason = error.strerror if isinstance(error, OSError) else error
        raise InputError(f"{path} cannot be read ({reason}); expected {expected}; correct the path") from error
    if not stat.S_ISREG(os.fstat(descriptor).st_mode):
        os.close(descriptor)
        raise InputError(f"{path} cannot be read (it is no regular file); expected {expected}; correct the path")
    with os.fdopen(descriptor, "rb") as file:
        yield file


def read_bytes(path: Path, expected: str) -> bytes:
    """Return the content of a regular file.

    Raises
    ------
    InputError
        If it cannot be read or is larger than `MOST_BYTES`.
    """
    with regular_file(path, expected) as file:
        size = os.fstat(file.fileno()).st_size
        if size > MOST_BYTES:
            raise InputError(f"{path} has {size} bytes; expected {expected} of at most {MOST_BYTES}; correct the path")
        return file.read()


def parsed_object(content: str | bytes, name: str, expected: str) -> dict[str, Any]:
    """Return the JSON object that a text holds.

    Raises
    ------
    InputError
        If it is no JSON object, names an entry twice, is nested too deep, or holds NaN, infinity or half a character.
    """
    try:
        text = content.decode("utf-8-sig") if isinstance(content, bytes) else content
        found = json.loads(text, parse_constant=_refuse_constant, object_pairs_hook=_once)
        _check_strings_and_levels(found)
    except (ValueError, RecursionError) as error:
        reason = _DEEP if isinstance(error, RecursionError) else error
        raise InputError(f"{name} is not JSON ({reason}); expected {expected}") from error
    if not isinstance(found, dict):
        raise InputError(f"{name} holds a JSON {type(found).__name__}; expected {expected}")
    return found


def _refuse_constant(name: str) -> float:
    raise ValueError(f"{name} is no JSON number")


def _once(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    content = dict(pairs)
    if len(content) < len(pairs):
        twice = Counter(name for name, _ in pairs).most_common(1)[0][0]
        raise ValueError(f"an object names {twice[:60]!r} twice")
    return content


def _check_strings_and_levels(content: object) -> None:
    level = [content]
    for _ in range(MOST_LEVELS):
        inner: list[object] = []
        for value in level:
            if isinstance(value, str) and not value.isascii():
                value.encode()  # UnicodeEncodeError, a ValueError, on a lone surrogate
            elif isinstance(value, dict):
                inner += [*value, *value.values()]
            elif isinstance(value, list):
                inner += value
        if not inner:
            return
        level = inner
    raise ValueError(_DEEP)
