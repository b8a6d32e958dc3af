"""Files that appear whole or not at all."""

import os
import secrets
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from femlib.errors import InputError


@contextmanager
def whole_file(target: Path) -> Iterator[Path]:
    """Give a temporary file beside `target` to fill, then rename it; if the filling fails, nothing is left.

    Raises
    ------
    InputError
        If the target is a folder or its folder cannot be written to.
    """
    if target.is_dir():
        raise InputError(f"{target} cannot be written (it is a folder); expected a file; add a name to it")
    temporary = target.with_name(f".{target.stem}.{secrets.token_hex(4)}{target.suffix}")
    try:
        temporary.open("x").close()
    except OSError as error:
        raise InputError(
            f"{target} cannot be written ({error.strerror}); expected a writable folder; create it"
        ) from error
    try:
        yield temporary
        os.replace(temporary, target)
    finally:
        temporary.unlink(missing_ok=True)
