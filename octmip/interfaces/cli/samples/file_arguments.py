"""Which arguments name files: what is read, and what is written, declared where the argument is added.

One check over the parsed arguments, before any work: no file that is read is written, no two outputs have one name, and
each output has a place. Completion of file names in a shell follows the same declarations.
"""

import argparse
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

from octmip.errors import DataError
from octmip.input.files import check_writable, is_same_file
from octmip.trees.methods.options import MODEL_FILE, all_options, values_of

READS, WRITES = "reads", "writes"
STANDARD_INPUT = "-"


def reads(action: argparse.Action, path_in: Callable[[str], str] = str) -> argparse.Action:
    """Declare that an argument names a file that is read; `path_in` takes its name out of a longer word."""
    return _declared(action, READS, path_in)


def writes(action: argparse.Action) -> argparse.Action:
    """Declare that an argument names a file that is written; a checkpoint is read as well, by its own search alone."""
    return _declared(action, WRITES, str)


def _declared(action: argparse.Action, use: str, path_in: Callable[[str], str]) -> argparse.Action:
    vars(action).update(file_use=use, path_in=path_in)
    return action


def use_of(action: argparse.Action) -> str | None:
    """Return what is done with the file that an argument names; None where it names none."""
    return vars(action).get("file_use")


def check_files(parser: argparse.ArgumentParser, arguments: argparse.Namespace) -> None:
    """Refuse outputs that would take the place of an input or of each other, or that have no place.

    Raises
    ------
    DataError
        see above; the sentence names both arguments.
    """
    inputs, outputs = list(_named(parser, arguments, READS)), list(_named(parser, arguments, WRITES))
    models = {name for name, one in all_options().items() if values_of(one) is MODEL_FILE}
    words = (word.partition("=") for word in getattr(arguments, "option", None) or ())
    outputs += [(f"--option {name}", Path(path)) for name, _, path in words if name in models and path]
    for number, (option, path) in enumerate(outputs):
        for other, read in inputs:
            if is_same_file(path, read):
                raise DataError(
                    f"{option} {path} is the file that {other} names, which would be overwritten; expected a file of "
                    "its own; give another name"
                )
        for other, written in outputs[:number]:
            if is_same_file(path, written):
                raise DataError(
                    f"{other} and {option} both name {path}, where one would overwrite the other; expected two files; "
                    "give another name"
                )
        check_writable(path)


def _named(parser: argparse.ArgumentParser, arguments: argparse.Namespace, use: str) -> Iterator[tuple[str, Path]]:
    for action in parser._actions:
        given: Any = getattr(arguments, action.dest, None)
        if use_of(action) == use and given is not None and given != STANDARD_INPUT:
            option = action.option_strings[0] if action.option_strings else str(action.metavar)
            yield option, Path(vars(action)["path_in"](given))
