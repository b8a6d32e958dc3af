"""The lines of a deck in text, those of the files that it includes in their places."""

from collections.abc import Callable, Iterator
from pathlib import Path

from femlib.errors import InputError
from femlib.files import read_bytes

MOST_FILES = 100
"""Files that a deck may include, at most: beyond it they include each other."""
Included = Callable[[str, Iterator[str]], tuple[str, str]]


def lines_of(
    path: Path, kind: str, included: Included, above: tuple[Path, ...] = (), n_files: list[int] | None = None
) -> Iterator[str]:
    """Give the lines of a deck.

    A file that it includes is looked for beside it, then beside those that include it, as the solvers do.

    Parameters
    ----------
    path : Path
        Of the deck.
    kind : str
        Its format, as a sentence names it.
    included : callable
        Takes a line and the ones behind it, and returns what of it stays, "" for nothing, and the file that it names.
    above : tuple of Path
        The deck's files that include this one, the nearest first.
    n_files : list of int
        How many were opened, by those that include this one.

    Raises
    ------
    InputError
        If a file cannot be read or is no text, or files include each other.
    """
    n_files = [0] if n_files is None else n_files
    n_files[0] += 1
    if n_files[0] > MOST_FILES:
        raise InputError(f"{path} is included by file {MOST_FILES} of a deck; expected fewer; files include each other")
    content = read_bytes(path, "a mesh file")
    try:
        text = content.decode("utf-8-sig")
    except UnicodeDecodeError:
        text = content.decode("cp1252", errors="replace")
    if "\0" in text:
        raise InputError(f"{path} could not be read as {kind} (it is no text); expected a deck; correct its ending")
    lines = iter(text.splitlines())
    for line in lines:
        kept, name = included(line, lines)
        if kept:
            yield kept
        if name:
            yield from lines_of(_found(name, (path, *above)), kind, included, (path, *above), n_files)


def _found(name: str, above: tuple[Path, ...]) -> Path:
    """Return the file that a deck includes, written for Windows or not."""
    places = [own.parent / name.replace("\\", "/") for own in above]
    found = next((place for place in places if place.is_file()), None)
    if found is None:
        raise InputError(
            f"{above[0]} includes {name}, which is not beside it; expected the whole deck; bring the file, or delete "
            "the line where the mesh does not need it"
        )
    return found
