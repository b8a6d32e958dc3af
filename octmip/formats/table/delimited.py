"""CSV and TSV: cells separated by commas, tabs or semicolons, one header line, numbers to the last bit."""

import contextlib
import csv
import io
import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import pandas as pd

from octmip.errors import DataError
from octmip.formats.table.names import check_names
from octmip.formats.table.source import Source
from octmip.input.cells import CsvRows

# From 3.1 on pandas reads numbers exactly by default and warns of the option; before, its default may be off.
IS_EXACT = tuple(int(part) for part in pd.__version__.split(".")[:2]) >= (3, 1)
EXACT_NUMBERS: dict[str, Any] = {} if IS_EXACT else {"float_precision": "round_trip"}
QUOTED = re.compile('"[^"]*"')
# A whole cell that is a number: digits and one comma (or one point) among them, between two separators.
DECIMAL = r'(?:^|;)"?[+-]?\d+%s\d+(?:[eE][+-]?\d+)?"?(?=\r?$|;)'
SEPARATORS = {",": "commas", ";": "semicolons", "\t": "tabs", "|": "bars"}


@dataclass(frozen=True, slots=True)
class Marks:
    """What separates the cells of a text, and what begins the decimals of its numbers."""

    separator: str
    decimal: str

    @property
    def notes(self) -> tuple[str, ...]:
        """A sentence where the decimals begin with a comma."""
        return ("numbers are read with decimal commas, as the cells stand between semicolons",) * (self.decimal == ",")


def marks_of(name: str, text: str, form: str) -> Marks:
    """Return the marks of a text that begins with its header line; `name` is what a sentence calls its source.

    Tabs separate the cells of a TSV, commas those of a CSV; where its header line has none, semicolons, tabs or bars
    do. With semicolons a number may have a decimal comma.

    Raises
    ------
    DataError
        decimal commas and points are mixed.
    """
    separator = _separator_of(text, form)
    return Marks(separator, _decimal(name, text, separator))


def read_delimited(source: Source, as_text: str | None = None) -> tuple[pd.DataFrame, tuple[str, ...]]:
    """Return the table of a CSV or TSV text (marks: `marks_of`), and notes on how it was read.

    The column `as_text`, where there is one, stays as it is written.

    Raises
    ------
    DataError
        the text is no table, a row has more or fewer cells than the header, a column has no name or one that another
        has, or decimal commas and points are mixed.
    """
    text, notes = source.text()
    marks = marks_of(source.name, text, source.format)
    header = _check_header(source, text, marks.separator)
    try:
        frame: pd.DataFrame = pd.read_csv(
            io.StringIO(text),
            sep=marks.separator,
            decimal=marks.decimal,
            **EXACT_NUMBERS,
            keep_default_na=False,
            na_values=["", "nan", "NaN"],
            low_memory=False,
            dtype={} if as_text is None else {as_text: str},
        )
    except (ValueError, OverflowError) as error:  # pandas' own ParserError and EmptyDataError among them
        reason = str(error).strip().removeprefix("Error tokenizing data. C error: ")
        raise DataError(
            f"{source.name} is no table: {reason}; give every line as many cells as the header has"
        ) from error
    if list(frame.columns) != header:
        raise DataError(
            f"{source.name}, line 1: the header can be read in two ways; expected plain names; rename the columns"
        )
    if frame.iloc[:, -1].isna().any():  # pandas fills a row that is too short
        _refuse_short(source.name, text, marks.separator, len(header))
    return frame, (*notes, *marks.notes)


def ragged(n_cells: int, n_columns: int) -> str:
    """Return what is wrong with a row of another length than the header, behind its place."""
    return (
        f"{n_cells} cell{'s' * (n_cells != 1)} but the header has {n_columns}; give every row one for each column, an "
        "empty one where nothing is known"
    )


def _refuse_short(name: str, text: str, separator: str, n_columns: int) -> None:
    rows = _rows(text, separator)
    with contextlib.suppress(csv.Error):  # a cell that pandas takes and csv does not
        for cells in rows:
            if 0 < len(cells) < n_columns:
                raise DataError(f"{name}, line {rows.last}: {ragged(len(cells), n_columns)}")


def _separator_of(text: str, form: str) -> str:
    if form == "tsv":
        return "\t"
    header = QUOTED.sub("", text[: text.find("\n") + 1] or text)
    return next((mark for mark in SEPARATORS if mark in header), ",")


def line_of_row(source: Source, row: int) -> int | None:
    """Return the line of the text (1: header) on which a row ends: blank lines hold no row, quoted cells may span."""
    text, _ = source.text()
    rows = _rows(text, _separator_of(text, source.format))
    rows_before = -1  # the header
    with contextlib.suppress(csv.Error):  # a cell that pandas takes and csv does not: the row is named by its number
        for cells in rows:
            if cells:
                if rows_before == row:
                    return rows.last
                rows_before += 1
    return None


def _check_header(source: Source, text: str, separator: str) -> list[str]:
    """Return the names of the columns."""
    rows = _rows(text, separator)
    try:
        header: Sequence[str] = next(rows, [])
        first: Sequence[str] = next((cells for cells in rows if cells), [])
    except csv.Error as error:
        cells = f"cells separated by {SEPARATORS[separator]}"
        raise DataError(f"{source.name}, line {rows.last}: {error}; expected {cells}") from error
    check_names(source.name, header)
    if "" in (name.strip() for name in header):
        place = [name.strip() for name in header].index("") + 1
        raise DataError(
            f"{source.name}, line 1: column {place} has no name; name it, or drop it if it only counts the rows"
        )
    if len(first) > len(header):  # pandas would take the first column for an index
        raise DataError(f"{source.name}, line 2: {ragged(len(first), len(header))}, and name every column")
    return list(header)


def _decimal(name: str, text: str, separator: str) -> str:
    """Return the decimal mark of the numbers: a comma is one only between semicolons."""
    if separator != ";" or not (comma := re.search(DECIMAL % ",", text, re.MULTILINE)):
        return "."
    if point := re.search(DECIMAL % r"\.", text, re.MULTILINE):
        raise DataError(
            f"{name} holds numbers with a decimal comma ({comma[0].strip(';')}) and with a decimal point "
            f"({point[0].strip(';')}); expected one of the two; save the table with points"
        )
    return ","


def _rows(text: str, separator: str) -> CsvRows:
    return CsvRows(enumerate(io.StringIO(text, newline=""), start=1), separator=separator)
