"""A twin by one word, DOOR:WHERE, as the commands take it: a table or a Python object.

A table as a twin: one column per parameter, state and load, one per reading; between its rows it is interpolated.

Rows that form a regular grid are interpolated linearly along it, other rows linearly over a Delaunay triangulation.
Both are exact at the rows. Nothing is extrapolated: outside of the table there is no answer. The error between two rows
is at most k spacing^2 / 8 for a curvature k, so the spacing decides how exact the twin is.
"""

import importlib
import sys
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import LinearNDInterpolator, RegularGridInterpolator
from scipy.spatial import QhullError

from octmip.errors import DataError, TwinError
from octmip.formats.table import read_table
from octmip.gap.doors.card import Card, card_beside
from octmip.gap.doors.function import Function, FunctionTwin
from octmip.twin import Twin

Floats = NDArray[np.float64]
Given = str | Path | Card | None


def table_twin(path: str | Path, card: str | Path | Card | None = None, linear: bool = False) -> FunctionTwin:
    """Return the twin of a table, CSV or Parquet.

    Parameters
    ----------
    path
        the table: a header, numbers below it.
    card
        its card or the file of it; by default the file beside the table, its name with .json added.
    linear
        whether readings are proportional to the loads, where the card does not say so.

    Raises
    ------
    DataError
        no such file, a column of the card that it lacks, a cell that is no number.
    """
    if not Path(path).is_file():
        raise DataError(f"table {path} is not there; expected a CSV or Parquet file; check the path")
    known = card_beside(path, card, linear)
    inputs = [*known.ranges, *known.states, *known.loads]
    table = read_table(Path(path))
    table.refuse_other_units({**known.readings, **{name: own.unit for name, own in known.ranges.items()}})
    numbers = table.numbers([*inputs, *known.readings], "model")
    points, values = numbers[:, : len(inputs)], numbers[:, len(inputs) :]
    limits = {name: float(points[:, inputs.index(name)].max()) for name in known.states}
    return FunctionTwin(_interpolated(points, values, inputs, str(path)), replace(known, state_limits=limits))


def _interpolated(points: Floats, values: Floats, names: list[str], path: str) -> Function:
    """Return the function that interpolates rows of points (n, n_inputs) and values (n, n_readings)."""
    _refuse_equal_rows(points, names, path)
    varied = [k for k in range(points.shape[1]) if np.ptp(points[:, k]) > 0.0]
    low, high = points.min(axis=0), points.max(axis=0)
    inside = _of_points(points[:, varied], values, [names[k] for k in varied], path)

    def function(parameters: Mapping[str, float], loads: Mapping[str, float]) -> Floats:
        given = {**parameters, **loads}
        asked = np.array([given[name] for name in names])
        beyond = np.flatnonzero((asked < low - _slack(low, high)) | (asked > high + _slack(low, high)))
        if beyond.size:
            k = int(beyond[0])
            raise TwinError(
                f"table {path} was asked for {names[k]} {asked[k]:g}; it holds {low[k]:g} to {high[k]:g}, and nothing "
                "is extrapolated; add rows that reach it"
            )
        return np.asarray(inside(np.clip(asked, low, high)[varied]), dtype=np.float64)

    return function


def _slack(low: Floats, high: Floats) -> Floats:
    """Return what rounding may add at the ends of a column."""
    return 1e-9 * np.maximum(high - low, np.maximum(np.abs(low), np.abs(high)))


def _of_points(points: Floats, values: Floats, names: list[str], path: str) -> Any:
    """Return the interpolator of the columns that vary: along a grid, else over triangles."""
    if not names:
        return lambda at: values.mean(axis=0)
    axes = [np.unique(points[:, k]) for k in range(len(names))]
    if len(points) == np.prod([len(axis) for axis in axes]):  # no row comes twice, so all of the grid is there
        grid = values[np.lexsort(points.T[::-1])].reshape(*map(len, axes), values.shape[1])
        regular = RegularGridInterpolator(axes, grid, method="linear")
        return lambda at: regular(at)[0]
    width = np.ptp(points, axis=0)
    try:
        scattered = LinearNDInterpolator(points / width, values)
    except QhullError as error:
        raise DataError(
            f"table {path} has {len(points)} rows that span no area in {', '.join(names)}, so nothing lies between "
            "them; expected rows that do, a grid for instance; add rows, or leave one of these columns constant"
        ) from error

    def inside(at: Floats) -> Floats:
        found = np.asarray(scattered(at / width), dtype=np.float64).reshape(-1)
        if not np.isfinite(found).all():
            where = ", ".join(f"{name} {value:g}" for name, value in zip(names, at, strict=True))
            raise TwinError(
                f"table {path} was asked for {where}, outside of its rows; nothing is extrapolated; add rows about it"
            )
        return found

    return inside


def _refuse_equal_rows(points: Floats, names: list[str], path: str) -> None:
    """Refuse two rows (n, n_inputs) of the same inputs: which of their readings holds is not known."""
    _, row_of, count = np.unique(points, axis=0, return_inverse=True, return_counts=True)
    if (count > 1).any():
        same = np.flatnonzero(row_of.ravel() == int(np.argmax(count > 1)))[:2]
        values = zip(names, points[same[0]], strict=True)
        at = ", ".join(f"{name} {value:g}" for name, value in values) or "inputs, none"
        raise DataError(
            f"table {path}, rows {same[0] + 2} and {same[1] + 2} hold the same {at}; expected one row for each; drop "
            "one, or average them"
        )


TABLE, PYTHON = "table", "python"
"""The doors; that of a Python object may be left out."""
DOORS = (TABLE, PYTHON)
PARTS = ("gauges", "predict", "effects")
"""What every twin has."""


def open_twin(name: str, card: Given = None, linear: bool = False) -> Twin:
    """Return the twin behind ``table:FILE`` or ``python:MODULE:NAME``.

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
    if door == TABLE:
        if not where:
            raise DataError(
                f"twin {name!r} says no place; expected {TABLE}:FILE, such as table:beam.csv; give the file"
            )
        return table_twin(where, card, linear)
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
            f"--twin is {name!r}; expected MODULE:NAME, such as femlib.wing:uav_twin, or {TABLE}, a colon, and the file"
        )
    if "" not in sys.path:
        # A twin beside the campaign, in the working directory; last, so that no folder there hides a package.
        sys.path.append("")
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
