"""A twin by one word: DOOR:WHERE, as the commands take it."""

import importlib
import sys
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from octmip.errors import DataError
from octmip.gap.doors.card import card_beside
from octmip.gap.doors.function import FunctionTwin
from octmip.gap.doors.script import script_twin
from octmip.gap.doors.table import table_twin
from octmip.twin import Twin

Given = str | Path | None


def _script(path: str, card: Given, linear: bool) -> FunctionTwin:
    return script_twin(path, card, linear=linear)


FILES: Mapping[str, Callable[[str, Given, bool], FunctionTwin]] = {"table": table_twin, "script": _script}
"""Doors of files, by name."""
PYTHON = "python"
"""The door of a Python object; it may be left out."""
DOORS = (*FILES, PYTHON)
PARTS = ("gauges", "predict", "effects")
"""What every twin has."""


def open_twin(name: str, card: Given = None, linear: bool = False) -> Twin:
    """Return the twin behind ``table:FILE``, ``script:FILE`` or ``python:MODULE:NAME``.

    Parameters
    ----------
    name
        door and place; a Python object needs no door.
    card
        file of the card; by default of a file the one beside it, its name with .json added. With a card a Python object
        is a function of parameters and loads, else a twin, its class, or a function that makes one.
    linear
        whether readings are proportional to the loads, where the card does not say so.

    Raises
    ------
    DataError
        no such door, file, object or card; an object that gives no twin.
    """
    door, _, where = name.partition(":")
    if door in FILES:
        if not where:
            raise DataError(
                f"twin {name!r} says no place; expected {door}:FILE, such as {door}:beam.csv; give the file"
            )
        return FILES[door](where, card, linear)
    where = where if door == PYTHON else name
    if card is not None:
        return FunctionTwin(_attribute(where), card_beside(where, card, linear))
    twin = _object_twin(where)
    if linear and not getattr(twin, "is_linear_in_load", False):
        raise DataError(f"twin {name!r} does not say that it is linear in its loads; set its is_linear_in_load = True")
    return twin


def _attribute(name: str) -> Any:
    """Return what ``module:attribute`` names."""
    module, colon, attribute = name.partition(":")
    if not (module and colon and attribute):
        raise DataError(
            f"--twin is {name!r}; expected MODULE:NAME, such as femlib.wing:uav_twin, or {' or '.join(FILES)}, a "
            "colon, and the file"
        )
    if "" not in sys.path:
        sys.path.insert(0, "")  # a twin beside the campaign, in the working directory
    try:
        return getattr(importlib.import_module(module), attribute)
    except ImportError as error:
        raise DataError(
            f"--twin {name!r}: module {module!r} cannot be imported ({error}); expected MODULE:NAME, or a door such as "
            "table:FILE.csv; check the name"
        ) from error
    except AttributeError as error:
        raise DataError(f"--twin {name!r}: {module!r} has no {attribute!r}; check the name") from error


def _object_twin(name: str) -> Twin:
    """Return the twin that ``module:attribute`` names, called first when it is no twin itself."""
    found = _attribute(name)
    twin = found if hasattr(found, "predict") and not isinstance(found, type) else _made(name, found)
    if not all(hasattr(twin, part) for part in PARTS):
        raise DataError(
            f"--twin {name!r} gives a {type(twin).__name__}; expected gauges, effects and predict(state, load)"
        )
    checked: Twin = twin
    return checked


def _made(name: str, maker: Any) -> Any:
    """Return what a twin's class or function makes, called without arguments."""
    try:
        return maker()
    except TypeError as error:
        raise DataError(
            f"--twin {name!r} cannot be called without arguments ({error}); expected a twin, its class, a function "
            "that makes one, or a model f(parameters, loads) beside its card; write such a function, or give the card "
            "(--card CARD.json)"
        ) from error
