"""The file of a campaign: CSV, validated cell by cell; every complaint names the row and the column.

Columns: ``test``, ``load_factor``, one for each known state parameter (fractions; empty is unknown), optional ``time``
[s] and ``temperature`` [deg C], then one for each gauge under the twin's name, in microstrain. Lines that begin with #
are comments. Rows are numbered as a text editor numbers its lines.
"""

import csv
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from octmip.errors import DataError
from octmip.gap.campaign import Campaign
from octmip.twin import Twin, state_parameters

UNIT_FACTOR = 100.0
"""Readings and twin further apart than this factor are in other units, not in another physics."""
SMALLEST_SIGNAL = 20.0
"""Predictions below this [microstrain] say nothing about the unit."""

Row = tuple[int, list[str]]


def read_campaign(path: str | Path, twin: Twin) -> Campaign:
    """Return the campaign in a CSV file, its columns matched with the twin's gauges and state parameters.

    Raises:
        DataError: an unknown or missing column, a cell that is no number, a load factor left out, units a factor off,
            all readings equal; the message names the row and the column.
    """
    header, rows = _table(Path(path))
    gauges = tuple(name for name in header if name in twin.gauges)
    parameters = state_parameters(twin)
    _check_header(header, twin.gauges, parameters)
    columns = {name: k for k, name in enumerate(header)}
    numbers = {name: _column(rows, columns[name], name) for name in header if name != "test"}
    n = len(rows)
    absent = np.full(n, np.nan)
    states = np.array([numbers.get(name, absent) for name in parameters]).reshape(len(parameters), n).T
    _refuse_missing(numbers["load_factor"], rows, "load_factor")
    _refuse_fractions(states, parameters, rows)
    readings = np.array([numbers[name] for name in gauges]).T
    _refuse_equal(readings, rows)
    _refuse_units(readings, numbers["load_factor"], gauges, twin, rows)
    return Campaign(
        gauges=gauges,
        parameters=parameters,
        test=tuple(_text(row, columns["test"]) for row in rows),
        load_factor=numbers["load_factor"],
        states=states,
        readings=readings,
        time=numbers.get("time", absent),
        temperature=numbers.get("temperature", absent),
        notes=tuple(_notes(readings, gauges, twin, parameters, states)),
    )


def _table(path: Path) -> tuple[list[str], list[Row]]:
    if not path.is_file():
        raise DataError(f"campaign file {path} is not there; expected a CSV file")
    try:
        text = path.read_text(encoding="utf-8-sig")
    except UnicodeDecodeError as error:
        raise DataError(f"campaign file {path} is not UTF-8 text ({error}); save it as CSV in UTF-8") from error
    lines = [(k + 1, line) for k, line in enumerate(text.splitlines()) if line.strip() and not line.startswith("#")]
    if len(lines) < 2:
        raise DataError(f"campaign file {path} has {len(lines)} lines; expected a header and at least one reading")
    cells = list(csv.reader([line for _, line in lines]))
    header = [name.strip() for name in cells[0]]
    for (number, _), row in zip(lines[1:], cells[1:], strict=True):
        if len(row) != len(header):
            raise DataError(f"row {number} has {len(row)} columns but the header has {len(header)}; complete the row")
    return header, [(number, row) for (number, _), row in zip(lines[1:], cells[1:], strict=True)]


def _check_header(header: list[str], gauges: tuple[str, ...], parameters: tuple[str, ...]) -> None:
    twice = sorted({name for name in header if header.count(name) > 1})
    if twice:
        raise DataError(f"row 1 (header): column {twice[0]!r} stands {header.count(twice[0])} times; name it once")
    for name in ("test", "load_factor"):
        if name not in header:
            raise DataError(f"row 1 (header): column {name!r} is missing; got {header[:6]}...; add it to every row")
    known = {"test", "load_factor", "time", "temperature", *gauges, *parameters}
    unknown = [name for name in header if name not in known]
    if unknown:
        raise DataError(
            f"row 1 (header): column {unknown[0]!r} is no gauge and no state parameter of the twin; expected among "
            f"{list(gauges[:3])}...{list(gauges[-1:])}, {list(parameters)}, time, temperature; rename or drop it"
        )
    if not any(name in gauges for name in header):
        raise DataError(f"row 1 (header): no gauge column; expected names such as {list(gauges[:3])}")


def _column(rows: list[Row], position: int, name: str) -> NDArray[np.float64]:
    values = np.full(len(rows), np.nan)
    for k, (number, cells) in enumerate(rows):
        text = cells[position].strip()
        if not text:
            continue
        try:
            values[k] = float(text)
        except ValueError:
            raise DataError(f"row {number}, column {name} is {text!r}; expected a number or nothing") from None
        if not np.isfinite(values[k]):
            raise DataError(
                f"row {number}, column {name} is {text!r}; expected a finite number; leave it empty if missing"
            )
    return values


def _text(row: Row, position: int) -> str:
    name = row[1][position].strip()
    if not name:
        raise DataError(f"row {row[0]}, column test is empty; give every reading the name of its test")
    return name


def _refuse_missing(values: NDArray[np.float64], rows: list[Row], name: str) -> None:
    missing = np.flatnonzero(np.isnan(values))
    if missing.size:
        raise DataError(
            f"row {rows[missing[0]][0]}, column {name} is empty ({missing.size} such rows); give it for every reading"
        )


def _refuse_fractions(states: NDArray[np.float64], parameters: tuple[str, ...], rows: list[Row]) -> None:
    bad = np.argwhere((states < 0.0) | (states >= 1.0))
    if len(bad):
        row, column = (int(k) for k in bad[0])
        raise DataError(
            f"row {rows[row][0]}, column {parameters[column]} is {states[row, column]:g}; expected a fraction of 0 to "
            "below 1 (0.2 for 20 %)"
        )


def _refuse_equal(readings: NDArray[np.float64], rows: list[Row]) -> None:
    finite = readings[np.isfinite(readings)]
    if finite.size > 1 and np.ptp(finite) == 0.0:
        raise DataError(
            f"rows {rows[0][0]} to {rows[-1][0]}: all {finite.size} readings in the gauge columns are equal "
            f"({finite[0]:g}); expected measured values; the logger recorded nothing"
        )


def _refuse_units(
    readings: NDArray[np.float64], loads: NDArray[np.float64], gauges: tuple[str, ...], twin: Twin, rows: list[Row]
) -> None:
    """Compare the size of each row with the healthy prediction: a factor of 1000 is a unit, not an effect."""
    order = [twin.gauges.index(name) for name in gauges]
    predicted = {load: np.abs(twin.predict({}, load))[order] for load in set(loads.tolist())}
    typical = np.array([float(np.median(predicted[load])) for load in loads.tolist()])
    size = np.array([float(np.nanmedian(np.abs(r))) if np.isfinite(r).any() else np.nan for r in readings])
    tested = (typical > SMALLEST_SIGNAL) & np.isfinite(size)
    if not tested.any():
        return
    ratio = float(np.median(size[tested] / typical[tested]))
    if UNIT_FACTOR**-1 < ratio < UNIT_FACTOR:
        return
    row = int(np.flatnonzero(tested)[0])
    raise DataError(
        f"row {rows[row][0]}, columns {gauges[0]} to {gauges[-1]}: readings are {ratio:.3g} times what the twin "
        f"predicts (median {size[row]:.3g} against {typical[row]:.3g} microstrain); expected microstrain; convert them"
    )


def _notes(
    readings: NDArray[np.float64],
    gauges: tuple[str, ...],
    twin: Twin,
    parameters: tuple[str, ...],
    states: NDArray[np.float64],
) -> list[str]:
    notes = []
    missing = float(np.isnan(readings).mean())
    if missing > 0.0:
        notes.append(f"{100 * missing:.0f} % of the readings are missing; every mean uses what was recorded.")
    absent = [name for name in twin.gauges if name not in gauges]
    if absent:
        notes.append(f"{len(absent)} of the twin's gauges are not in the file ({', '.join(absent[:6])}); not used.")
    if parameters and np.isnan(states).any():
        notes.append("Some states are unknown; the diagnosis holds them open and marginalises them.")
    return notes
