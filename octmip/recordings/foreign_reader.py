"""Calls of somebody else's reader: what it prints or warns becomes notes, what it raises becomes one sentence."""

import contextlib
import gc
import io
import logging
import re
import sys
import traceback
import warnings
from collections.abc import Iterator

from octmip.errors import DataError, OctmipError

LETTERS, MOST = 200, 3
"""Characters of a message that a sentence repeats, and messages."""


@contextlib.contextmanager
def foreign(path: str, form: str) -> Iterator[list[str]]:
    """Run a reader of this format within the context; the list holds what it said, once it has ended.

    Raises
    ------
    DataError
        it raised anything, as damaged files make readers do.
    """
    said, printed, logs = list[str](), io.StringIO(), logging.root.manager.disable
    logging.disable(logging.CRITICAL)  # some log whole pieces of a damaged file
    try:
        with (
            warnings.catch_warnings(record=True) as caught,
            contextlib.redirect_stdout(printed),
            contextlib.redirect_stderr(printed),
        ):
            warnings.simplefilter("always")
            yield said
    except OctmipError:
        raise
    except Exception as error:
        reason = _one_line(f"{type(error).__name__}: {error}")
        _end_quietly(error)
        raise DataError(f"{path} cannot be read as {form} ({reason}); was it written to the end?") from error
    finally:
        logging.disable(logs)
    warned = [str(one.message) for one in caught if issubclass(one.category, UserWarning)]
    lines = list(
        dict.fromkeys(_one_line(words) for words in (*warned, *printed.getvalue().splitlines()) if words.strip())
    )
    said += [f"Its reader says: {words}" for words in lines[:MOST]]
    if len(lines) > MOST:
        said.append(f"Its reader says {len(lines) - MOST} things more.")


def _end_quietly(error: Exception) -> None:
    """End the objects of a reader that failed: some complain on standard error that they hold no file to close."""
    hook = sys.unraisablehook
    sys.unraisablehook = lambda _: None
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            cause: BaseException | None = error
            while cause is not None:
                traceback.clear_frames(cause.__traceback__)
                cause = cause.__context__
            gc.collect()
    finally:
        sys.unraisablehook = hook


def _one_line(words: str) -> str:
    return re.sub(r"\s+", " ", words)[:LETTERS]
