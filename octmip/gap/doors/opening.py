"""A twin by one word: DOOR:WHERE, as the command takes it."""

from pathlib import Path

from octmip.errors import DataError
from octmip.gap.doors.deck import deck_twin
from octmip.gap.doors.fmu import fmu_twin
from octmip.gap.doors.function import FunctionTwin
from octmip.gap.doors.script import script_twin
from octmip.gap.doors.table import table_twin
from octmip.gap.doors.um_bridge import um_bridge_twin

DOORS = ("table", "um-bridge", "fmu", "deck", "script")
"""Doors besides a Python object."""


def door_of(name: str) -> str:
    """Return the door that a name such as ``table:FILE.csv`` begins with, "" where it begins with none."""
    before, colon, _ = name.partition(":")
    return before if colon and before in DOORS else ""


def open_twin(name: str, card: str | Path | None = None) -> FunctionTwin:
    """Return the twin behind ``table:FILE``, ``um-bridge:ADDRESS``, ``fmu:FILE``, ``deck:FILE`` or ``script:FILE``.

    Parameters
    ----------
    name
        door and place.
    card
        file of the card; by default the one beside the file, its name with .json added.

    Raises
    ------
    DataError
        no such door, file, model or card.
    """
    door, where = door_of(name), name.partition(":")[2]
    if not door or not where:
        raise DataError(f"twin {name!r} names no door; expected one of {', '.join(DOORS)}, a colon, and where it is")
    if door == "um-bridge":
        if card is None:
            raise DataError(
                f"twin {name!r} needs a card, for UM-Bridge knows no names; give its file (--card CARD.json)"
            )
        return um_bridge_twin(where, card)
    if door == "table":
        return table_twin(where, card)
    if door == "fmu":
        return fmu_twin(where, card)
    return deck_twin(where, card) if door == "deck" else script_twin(where, card)
