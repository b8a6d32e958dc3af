"""Files that appear whole or not at all, and reading whose failure is one sentence."""

import contextlib
import json
import os
import secrets
from pathlib import Path

from octmip.errors import DataError

PathLike = str | os.PathLike[str]


def write_bytes(path: PathLike, content: bytes) -> None:
    """Write a file whole or not at all: under a passing name, flushed to the disk, then renamed into place.

    Raises:
        DataError: the file cannot be written.
    """
    try:
        if Path(path).exists() and not Path(path).is_file():
            Path(path).write_bytes(content)  # a device or pipe: nothing to rename
        else:  # through a link, so that the link stays and its target is replaced
            _replace(Path(os.path.realpath(path)), content)
    except OSError as error:
        raise DataError(f"{path} cannot be written ({error.strerror}); choose another place") from error


def _replace(target: Path, content: bytes) -> None:
    passing = target.with_name(f".{target.name}.{secrets.token_hex(4)}")
    try:
        with passing.open("xb") as file:
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

    Raises:
        DataError: the folder is missing or not writable, or the path is a folder.
    """
    target = Path(os.path.realpath(path))
    if target.is_dir():
        raise DataError(f"{path} is a folder; expected the name of a file to write")
    if Path(path).exists() and not Path(path).is_file():
        return  # a device or pipe: opening it is the only test, and may block
    if not target.parent.is_dir():
        raise DataError(f"{path} cannot be written: there is no folder {target.parent}; make it first")
    if not os.access(target.parent, os.W_OK):
        raise DataError(f"{path} cannot be written: folder {target.parent} is not writable; choose another place")


def read_bytes(path: PathLike) -> bytes:
    """Return the content of a file.

    Raises:
        DataError: it cannot be read, or is empty.
    """
    try:
        content = Path(path).read_bytes()
    except OSError as error:
        raise DataError(f"{path} cannot be read ({error.strerror}); expected a readable file") from error
    if not content.strip():
        raise DataError(f"{path} is empty ({len(content)} bytes); expected its content; was it written to the end?")
    return content


def read_text(path: PathLike) -> str:
    """Return the content of a UTF-8 file, without a byte-order mark.

    Raises:
        DataError: it cannot be read, is empty, or holds bytes that are not UTF-8.
    """
    content = read_bytes(path)
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = content[: error.start].count(b"\n") + 1
        raise DataError(
            f"{path}, line {line}: byte 0x{content[error.start]:02x} is not UTF-8 text; save the file as UTF-8"
        ) from error


def read_json_object(path: PathLike) -> dict[str, object]:
    """Return the one JSON object that a file holds.

    Raises:
        DataError: it cannot be read, ends early, or holds anything else.
    """
    text = read_text(path)
    try:
        content = json.loads(text, parse_constant=_refuse_constant)
    except json.JSONDecodeError as error:
        ends = not text[error.pos :].strip() or error.msg.startswith("Unterminated")
        what = "the file ends in the middle; was it cut?" if ends else "expected JSON"
        raise DataError(f"{path}, line {error.lineno}, column {error.colno}: {error.msg}; {what}") from error
    except (ValueError, RecursionError) as error:
        raise DataError(f"{path} is not JSON that can be read ({error})") from error
    if not isinstance(content, dict):
        raise DataError(f"{path} holds a JSON {type(content).__name__}; expected one object {{...}}")
    return content


def _refuse_constant(name: str) -> float:
    raise ValueError(f"{name} is no JSON number")
