"""Files that appear whole or not at all, and reading whose failure is one sentence."""

import codecs
import contextlib
import json
import os
import secrets
import shutil
import stat
import warnings
from collections import Counter
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, TypeVar

from octmip.errors import DataError, WriteError
from octmip.input.messages import MOST_NAME, shown

PathLike = str | os.PathLike[str]
T = TypeVar("T")
MOST_BYTES = 2**32
"""Size of a file that is read whole: beyond it memory ends before a sentence can be said."""
MOST_LEVELS = 100
"""Levels of lists and objects in a JSON file; the deepest tree has some thirty."""
MARKED = {
    codecs.BOM_UTF8: "utf-8-sig",
    codecs.BOM_UTF32_LE: "utf-32",  # begins as the mark of UTF-16 does
    codecs.BOM_UTF32_BE: "utf-32",
    codecs.BOM_UTF16_LE: "utf-16",
    codecs.BOM_UTF16_BE: "utf-16",
}
"""Encodings by the byte-order mark that begins a text."""
_DEEP = f"nested deeper than {MOST_LEVELS} levels"


def write_bytes(path: PathLike, content: bytes) -> None:
    """Write a file whole or not at all: under a passing name, flushed to the disk, then renamed into place.

    Raises
    ------
    WriteError
        the file cannot be written.
    """
    try:
        if Path(path).exists() and not Path(path).is_file():
            Path(path).write_bytes(content)  # a device or pipe: nothing to rename
        else:  # through a link, so that the link stays and its target is replaced
            _replace(Path(os.path.realpath(path)), content)
    except OSError as error:
        raise WriteError(f"{path} cannot be written ({error.strerror}); choose another place") from error


def make_folder(path: PathLike) -> Path:
    """Return a folder, made with those above it where it is not there.

    Raises
    ------
    WriteError
        it cannot be made.
    """
    try:
        Path(path).mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise WriteError(f"folder {shown(str(path))} cannot be made ({error.strerror}); name another") from error
    return Path(path)


@contextlib.contextmanager
def whole_folder(path: PathLike) -> Iterator[Path]:
    """Yield a passing folder whose files move to `path` when the block has ended, and vanish where it fails.

    It lies in the folder of that name, or beside it where there is none; other files of that folder stay.

    Raises
    ------
    WriteError
        the folder or its files cannot be written.
    """
    target = Path(os.path.realpath(path))
    if target.exists():
        make_folder(path)  # refuses a file of that name
    within = target if target.is_dir() else target.parent
    passing = make_folder(within / f".{target.name}.{secrets.token_hex(4)}")
    try:
        yield passing
        if not target.exists():
            _moved(passing, target)  # at once
        for file in sorted(passing.rglob("*")):
            place = target / file.relative_to(passing)
            if file.is_dir():
                make_folder(place)
            else:
                make_folder(place.parent)
                _moved(file, place)
    finally:
        shutil.rmtree(passing, ignore_errors=True)


def _moved(file: Path, place: Path) -> None:
    try:
        _keep_mode(file, place)
        os.replace(file, place)
    except OSError as error:
        raise WriteError(f"{place} cannot be written ({error.strerror}); choose another place") from error


def keep_bytes(path: PathLike, content: bytes) -> None:
    """Write a file as `write_bytes`, or warn where that fails: what is kept on the way is not worth the work itself."""
    try:
        write_bytes(path, content)
    except WriteError as error:
        warn_not_kept(error)


def warn_not_kept(reason: WriteError) -> None:
    """Warn that a file of what was found so far could not be written."""
    warnings.warn(f"{reason}; the work goes on, and the next time it is tried again", stacklevel=4)


def is_same_file(one: PathLike, other: PathLike) -> bool:
    """Whether two names mean one regular file, by links too, whether or not it exists; no device is one."""
    try:
        found = os.stat(one), os.stat(other)
    except OSError:  # one of them is not there: what counts is where it would be
        places = [os.path.normcase(os.path.realpath(path)) for path in (one, other)]
        return places[0] == places[1]
    return os.path.samestat(*found) and stat.S_ISREG(found[0].st_mode)


def _keep_mode(passing: Path, target: Path) -> None:
    """Give a file the permissions of the one that it replaces: what its owner alone may read stays so."""
    with contextlib.suppress(FileNotFoundError):
        os.chmod(passing, stat.S_IMODE(target.stat().st_mode))


def _replace(target: Path, content: bytes) -> None:
    passing = target.with_name(f".{target.name}.{secrets.token_hex(4)}")
    try:
        with passing.open("xb") as file:
            _keep_mode(passing, target)
            file.write(content)
            file.flush()
            os.fsync(file.fileno())
        os.replace(passing, target)
    except BaseException:
        with contextlib.suppress(FileNotFoundError):
            passing.unlink()
        raise


def check_writable(path: PathLike) -> None:
    """Refuse a place where `write_bytes` could not write, before hours are spent on what should go there.

    Raises
    ------
    DataError
        the folder is missing or not writable, or the path is a folder or a link to itself.
    """
    target = Path(os.path.realpath(path))
    if target.is_symlink():
        raise DataError(f"{path} is a link that leads to itself; expected the name of a file to write")
    if target.is_dir():
        raise DataError(f"{path} is a folder; expected the name of a file to write")
    if Path(path).exists() and not Path(path).is_file():
        return  # a device or pipe: opening it is the only test, and may block
    if not target.parent.is_dir():
        raise DataError(f"{path} cannot be written: there is no folder {target.parent}; make it first")
    if not os.access(target.parent, os.W_OK):
        raise DataError(f"{path} cannot be written: folder {target.parent} is not writable; choose another place")


def check_readable(path: PathLike) -> int:
    """Return the size [bytes] of a regular file that can be read; nothing is waited for.

    Raises
    ------
    DataError
        it cannot be read, is empty or too large, or is a folder, pipe or device.
    """
    return _opened(path, lambda descriptor: os.fstat(descriptor).st_size)


def read_bytes(path: PathLike) -> bytes:
    """Return the content of a regular file.

    Raises
    ------
    DataError
        it cannot be read, is empty or too large, or is a folder, pipe or device.
    """
    content = _opened(path, _everything)
    if not content.strip():
        raise DataError(f"{path} is empty ({len(content)} bytes); expected its content; was it written to the end?")
    return content


def read_head(path: PathLike, n_bytes: int) -> bytes:
    """Return the first bytes of a regular file, which tell its format.

    Raises
    ------
    DataError
        as `read_bytes`.
    """
    return _opened(path, lambda descriptor: os.read(descriptor, n_bytes))


def _everything(descriptor: int) -> bytes:
    with os.fdopen(descriptor, "rb", closefd=False) as file:
        return file.read()


def _opened(path: PathLike, use: Callable[[int], T]) -> T:
    """Return what `use` makes of a file's descriptor, once the file has proved regular and of a sane size."""
    try:
        # Without O_NONBLOCK a pipe that nobody writes to blocks the opening for ever.
        descriptor = os.open(path, os.O_RDONLY | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_BINARY", 0))
        try:
            found = os.fstat(descriptor)
            if not stat.S_ISREG(found.st_mode):
                kind = "a folder" if stat.S_ISDIR(found.st_mode) else "a pipe or device"
                raise DataError(f"{path} cannot be read (it is {kind}); expected a regular file; give one")
            if not 0 < found.st_size <= MOST_BYTES:
                size = f"empty ({found.st_size} bytes)" if not found.st_size else f"too large ({found.st_size} bytes)"
                raise DataError(
                    f"{path} is {size}; expected 1 to {MOST_BYTES} bytes of content; was it written to the end?"
                )
            return use(descriptor)
        finally:
            os.close(descriptor)
    except (OSError, ValueError) as error:
        if isinstance(error, DataError):
            raise
        reason = error.strerror if isinstance(error, OSError) else error
        raise DataError(f"{path} cannot be read ({reason}); expected a readable file") from error


def read_text(path: PathLike) -> str:
    """Return the content of a UTF-8 file, without a byte-order mark.

    Raises
    ------
    DataError
        it cannot be read, is empty, or holds bytes that are not UTF-8.
    """
    return decoded(read_bytes(path), str(path))


def decoded(content: bytes, name: str) -> str:
    """Return a text in UTF-8, or in what its byte-order mark says, without that; `name` is its source in a sentence.

    Raises
    ------
    DataError
        a byte is not UTF-8.
    """
    try:
        marked = next((code for mark, code in MARKED.items() if content.startswith(mark)), "utf-8")
        return content.decode(marked)
    except UnicodeDecodeError as error:
        line = content[: error.start].count(b"\n") + 1
        raise DataError(
            f"{name}, line {line}: byte 0x{content[error.start]:02x} is not {error.encoding.upper()} text; save the "
            "file as UTF-8"
        ) from error


def read_json_object(path: PathLike, expected: str = "one object {...}") -> dict[str, Any]:
    """Return the one JSON object that a file holds; a sentence calls it what was `expected`.

    Raises
    ------
    DataError
        it cannot be read, ends early, holds anything else, names an entry twice, is nested deeper than
        `MOST_LEVELS`, or holds half a character.
    """
    raw = read_bytes(path)
    begins = raw.removeprefix(codecs.BOM_UTF8).lstrip()
    if begins[:1] not in (b"{", b"["):
        line = begins[:MOST_NAME].decode("utf-8", "replace").splitlines()[0]
        raise DataError(f"{path} begins with {shown(line)}; expected JSON: {expected}; give that file")
    text = decoded(raw, str(path))
    try:
        content = json.loads(text, parse_constant=_refuse_constant, object_pairs_hook=_once)
        _check_strings_and_levels(content)
    except json.JSONDecodeError as error:
        ends = not text[error.pos :].strip() or error.msg.startswith("Unterminated")
        what = "the file ends in the middle; was it cut?" if ends else f"expected JSON: {expected}"
        raise DataError(f"{path}, line {error.lineno}, column {error.colno}: {error.msg}; {what}") from error
    except RecursionError as error:
        raise DataError(f"{path} is not JSON that can be read ({_DEEP}); write the file again") from error
    except ValueError as error:
        raise DataError(f"{path} is not JSON that can be read ({error}); correct it or write the file again") from error
    if not isinstance(content, dict):
        raise DataError(f"{path} holds a JSON {type(content).__name__}; expected one object {{...}}")
    return content


def _refuse_constant(name: str) -> float:
    raise ValueError(f"{name} is no JSON number")


def _once(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    content = dict(pairs)
    if len(content) < len(pairs):
        twice = Counter(name for name, _ in pairs).most_common(1)[0][0]
        raise ValueError(f"an object names {twice[:60]!r} twice, and only one of the two can be meant")
    return content


def _check_strings_and_levels(content: object) -> None:
    """Refuse what later code could not print, write or walk through: half characters, and bottomless nesting."""
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
