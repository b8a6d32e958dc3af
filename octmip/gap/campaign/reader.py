"""The file of a campaign: CSV or TSV, validated cell by cell; every complaint names the row and the column.

Columns: ``test``, one for each of the twin's loads (``load_factor`` for a twin that announces none), one for each known
state parameter (fractions; empty is unknown), optional ``time`` [s] and ``temperature`` [deg C], then one for each
gauge under the twin's name, in its unit. Encoding, separators and decimal marks are those of every other table
(`octmip.formats.table.delimited`). Lines that begin with # and empty lines are skipped. Rows have the numbers that a
text editor shows; a quoted cell may run over several lines, and its row has the number of its first.
"""

import csv
import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from octmip.errors import DataError
from octmip.formats.table.delimited import Marks, marks_of, ragged
from octmip.formats.table.source import open_source
from octmip.gap.campaign.campaign import Campaign
from octmip.gap.campaign.plausibility import Sheet, refuse_nonsense, warnings_on
from octmip.gap.twins import CachedTwin
from octmip.input.cells import CsvRows, plain_number
from octmip.twin import Twin, loads_of, sign_of, state_parameters, units_of


@dataclass(frozen=True, slots=True)
class CampaignTable:
    """The cells of a campaign's file as text.

    Attributes
    ----------
    header
        (n_columns,) names, spaces stripped.
    header_number
        line of the header.
    rows
        (n_rows,) cells (n_columns,) of each row.
    numbers
        (n_rows,) line of each row.
    marks
        what separates its cells and begins decimals.
    notes
        sentences on how the file was read.
    """

    header: tuple[str, ...]
    header_number: int
    rows: tuple[tuple[str, ...], ...]
    numbers: tuple[int, ...]
    marks: Marks
    notes: tuple[str, ...]

    def texts(self, name: str) -> tuple[str, ...]:
        """Return the cells (n_rows,) of a column, spaces stripped."""
        position = self.header.index(name)
        return tuple(row[position].strip() for row in self.rows)

    def floats(self, name: str) -> NDArray[np.float64]:
        """Return the numbers (n_rows,) of a column, NaN where the cell is empty.

        Raises
        ------
        DataError
            a cell is no finite number.
        """
        texts = (text.replace(self.marks.decimal, ".") for text in self.texts(name))
        return np.array([_number(text, k, name) for text, k in zip(texts, self.numbers, strict=True)])


def read_campaign_table(path: str | Path) -> CampaignTable:
    """Return the table in a campaign's file.

    Raises
    ------
    DataError
        no such file, no text, nothing in it, a row with more or fewer cells than the header.
    """
    path = Path(path)
    source = open_source(path)
    if source.format == "parquet":
        raise DataError(f"campaign file {path} is Parquet; expected CSV or TSV; export it as one of them")
    text, notes = source.text()
    lines = list(_content(text))
    marks = marks_of(source.name, "".join(line for _, line in lines), source.format)
    rows = list(_parsed(lines, marks.separator))
    if not rows:
        raise DataError(
            f"campaign file {path} is empty (lines that begin with # are comments); expected a header row and one row "
            "per reading; export the table again"
        )
    (number, head), body = rows[0], rows[1:]
    header = tuple(name.strip() for name in head)
    while len(header) > 1 and not header[-1] and all(len(r) == len(head) and not r[-1].strip() for _, r in body):
        header, head = header[:-1], head[:-1]
        body = [(k, row[:-1]) for k, row in body]  # a separator at the end of every line
    if not body:
        raise DataError(
            f"campaign file {path} has a header in row {number} and no reading (lines that begin with # are comments); "
            "expected one row per reading; add the readings"
        )
    for k, row in body:
        if len(row) != len(header):
            raise DataError(f"row {k}: {ragged(len(row), len(header))}")
    cells, numbers = tuple(tuple(row) for _, row in body), tuple(k for k, _ in body)
    return CampaignTable(header, number, cells, numbers, marks, (*notes, *marks.notes))


def _parsed(lines: Iterable[tuple[int, str]], separator: str) -> Iterator[tuple[int, list[str]]]:
    """Yield each row with the number of its first line."""
    rows = CsvRows(lines, strict=True, separator=separator)
    try:
        for row in rows:
            yield rows.first, row
    except csv.Error as error:
        raise DataError(
            f"row {rows.first} is not valid CSV ({error}); close its quotation marks or remove them"
        ) from error


def _content(text: str) -> Iterator[tuple[int, str]]:
    """Yield the lines with their numbers, comments and empty lines left out."""
    for number, line in enumerate(text.splitlines(keepends=True), start=1):
        if line.strip() and not line.startswith("#"):
            yield number, line


def _number(text: str, row: int, column: str) -> float:
    if not text:
        return float("nan")
    value = plain_number(text)
    if value is None:
        hint = "clear the cell if nothing is known"
        if "," in text:
            hint = "write decimal points and no thousands separators"
        raise DataError(f"row {row}, column {column} is {text!r}; expected a number or nothing; {hint}")
    if not np.isfinite(value):
        raise DataError(f"row {row}, column {column} is {text!r}; expected a finite number; leave it empty if missing")
    return value


HOTTEST = 150.0
"""Temperatures beyond this [deg C] are kelvin or Fahrenheit."""
MOST_LOAD = 1e9
"""Loads beyond this are no load on any structure, in whatever unit."""


def read_campaign(path: str | Path, twin: Twin) -> Campaign:
    """Return the campaign in a CSV file, its columns matched with the twin's gauges and state parameters.

    Raises
    ------
    DataError
        an unknown or missing column, a cell that is no number, a load left out, a test of two states,
        units a factor off, a turned sign, all readings equal; the message names the row and the column.
    """
    table = read_campaign_table(path)
    parameters, names, units = state_parameters(twin), loads_of(twin), units_of(twin)
    _check_header(table, twin)
    gauges = tuple(name for name in table.header if name in twin.gauges)
    order = [twin.gauges.index(name) for name in gauges]
    tests = _tests(table)
    applied = np.array([_load_column(table, name) for name in names]).reshape(len(names), len(tests)).T
    campaign = Campaign(
        gauges=gauges,
        parameters=parameters,
        test=tests,
        load_factor=applied[:, 0] if len(names) == 1 else applied,
        states=_states(table, parameters, tests),
        readings=np.array([table.floats(name) for name in gauges]).T,
        time=_optional(table, "time"),
        temperature=_optional(table, "temperature"),
        numbers=table.numbers,
        load_names=names,
        units=tuple(units[k] for k in order),
    )
    healthy = np.zeros_like(campaign.readings)
    asked = twin if isinstance(twin, CachedTwin) else CachedTwin(twin)
    for cell in campaign.cells:
        healthy[cell.rows] = asked.predict({}, cell.load)[order]
    sheet = Sheet(campaign, healthy, sign_of(twin), tuple(range(len(gauges))))
    refuse_nonsense(sheet)
    notes = (*table.notes, *warnings_on(sheet), *_notes(table, twin, campaign))
    return replace(campaign, notes=notes)


def _load_column(table: CampaignTable, name: str) -> NDArray[np.float64]:
    """Return the loads of a column, none missing, none at which a twin's own numbers overflow.

    Newtons for load factors are found later, beside the twin's strains.
    """
    values = table.floats(name)
    missing, huge = np.flatnonzero(np.isnan(values)), np.flatnonzero(np.abs(values) > MOST_LOAD)
    if missing.size:
        raise DataError(
            f"row {table.numbers[missing[0]]}, column {name} is empty ({missing.size} such "
            f"row{'s' * (missing.size != 1)}); give it for every reading"
        )
    if huge.size:
        of = "a load factor, 1 in steady level flight," if name == "load_factor" else "a number"
        raise DataError(
            f"row {table.numbers[huge[0]]}, column {name} is {values[huge[0]]:g}; expected {of} of at most "
            f"{MOST_LOAD:g}; correct it"
        )
    return values


def _check_header(table: CampaignTable, twin: Twin) -> None:
    gauges, parameters, loads = twin.gauges, state_parameters(twin), loads_of(twin)
    header, where = table.header, f"row {table.header_number} (header)"
    twice = sorted({name for name in header if header.count(name) > 1})
    if twice:
        raise DataError(f"{where}: column {twice[0]!r} stands {header.count(twice[0])} times; name it once")
    for name in ("test", *loads):
        if name not in header:
            raise DataError(f"{where}: column {name!r} is missing; got {list(header[:6])}...; add it to every row")
    known = ("test", *loads, "time", "temperature", *gauges, *parameters)
    unknown = [name for name in header if name not in known]
    if unknown:
        meant = next((name for name in known if _plain(name) == _plain(unknown[0])), None)
        cure = f"write {meant!r}" if meant else "rename or drop it"
        raise DataError(
            f"{where}: column {unknown[0]!r} is no gauge and no state parameter of the twin; expected among "
            f"{list(gauges[:3])}...{list(gauges[-1:])}, {list(parameters)}, time, temperature; {cure}"
        )
    if not any(name in gauges for name in header):
        raise DataError(f"{where}: no gauge column; expected names such as {list(gauges[:3])}; add the gauges")


def _plain(name: str) -> str:
    """Return a name without case, marks and leading zeros: G-1 is g01."""
    letters = re.sub(r"[^a-z0-9]", "", name.lower())
    return re.sub(r"(?<!\d)0+(?=\d)", "", letters)


def _tests(table: CampaignTable) -> tuple[str, ...]:
    tests = table.texts("test")
    for name, number in zip(tests, table.numbers, strict=True):
        if not name:
            raise DataError(f"row {number}, column test is empty; give every reading the name of its test")
    return tests


def _optional(table: CampaignTable, name: str) -> NDArray[np.float64]:
    return table.floats(name) if name in table.header else np.full(len(table.rows), np.nan)


def _states(table: CampaignTable, parameters: tuple[str, ...], tests: tuple[str, ...]) -> NDArray[np.float64]:
    """Return the states (n_rows, n_parameters); refuse what is no fraction, and a test of two states."""
    states = np.array([_optional(table, name) for name in parameters]).reshape(len(parameters), len(tests)).T
    bad = np.argwhere((states < 0.0) | (states >= 1.0))
    if len(bad):
        row, column = (int(k) for k in bad[0])
        raise DataError(
            f"row {table.numbers[row]}, column {parameters[column]} is {states[row, column]:g}; expected a fraction of "
            "0 to below 1 (0.2 for 20 %); correct it"
        )
    first: dict[str, int] = {}
    for row, test in enumerate(tests):
        start = first.setdefault(test, row)
        apart = np.flatnonzero(~np.isclose(states[row], states[start], rtol=0.0, atol=1e-12, equal_nan=True))
        if apart.size:
            name = parameters[int(apart[0])]
            here, there = (_shown(states[k, int(apart[0])]) for k in (row, start))
            raise DataError(
                f"row {table.numbers[row]}, column {name} is {here} but row {table.numbers[start]} of the same test "
                f"{test!r} has {there}; expected one state per test; give the tests two names, or both rows the same"
            )
    return states


def _shown(value: float) -> str:
    return "empty" if np.isnan(value) else f"{value:g}"


def _notes(table: CampaignTable, twin: Twin, campaign: Campaign) -> list[str]:
    """Return a sentence on what the file leaves out, and on times and temperatures that cannot be."""
    notes, time, temperature = [], campaign.time, campaign.temperature
    absent = [name for name in twin.gauges if name not in campaign.gauges]
    if absent:
        notes.append(f"{len(absent)} of the twin's gauges are not in the file ({', '.join(absent[:6])}); not used.")
    if np.isnan(campaign.states).any():
        notes.append("Some states are unknown; the diagnosis marginalises over them.")
    missing = np.flatnonzero(np.isnan(time))
    if 0 < missing.size < len(time):
        notes.append(f"Row {table.numbers[missing[0]]}, column time is empty: times are not used.")
    back = np.flatnonzero(np.diff(time) < 0.0)
    if back.size:
        notes.append(f"Row {table.numbers[back[0] + 1]}, column time: earlier than the row before; order rows by time.")
    hot = np.flatnonzero(temperature > HOTTEST)
    if hot.size:
        notes.append(
            f"Row {table.numbers[hot[0]]}, column temperature is {temperature[hot[0]]:g}; expected degrees Celsius."
        )
    return notes
