"""A twin by one word: DOOR:WHERE, as the command takes it."""

from collections.abc import Callable, Mapping
from pathlib import Path

from octmip.errors import DataError
from octmip.gap.doors.function import FunctionTwin
from octmip.gap.doors.script import script_twin
from octmip.gap.doors.table import table_twin

DOORS: Mapping[str, Callable[[str, str | Path | None], FunctionTwin]] = {"table": table_twin, "script": script_twin}
"""Doors beside a Python object, by name."""


def door_of(name: str) -> str:
    """Return the door that a name such as ``table:FILE.csv`` begins with, "" where it begins with none."""
    before, colon, _ = name.partition(":")
    return before if colon and before in DOORS else ""


def open_twin(name: str, card: str | Path | None = None) -> FunctionTwin:
    """Return the twin behind ``table:FILE`` or ``script:FILE``.

    Parameters
    ----------
    name
        door and place.
    card
        file of the card; by default the one beside the file, its name with .json added.

    Raises
    ------
    DataError
        no such door, file or card.
    """
    door, where = door_of(name), name.partition(":")[2]
    if not door or not where:
        raise DataError(f"twin {name!r} names no door; expected one of {', '.join(DOORS)}, a colon, and where it is")
    return DOORS[door](where, card)
