"""CSV and TSV: cells separated by commas, tabs or semicolons, one header line, numbers to the last bit."""

import contextlib
import csv
import io
import re
from collections.abc import Sequence
from typing import Any

import pandas as pd

from octmip.errors import DataError
from octmip.formats.cells import CsvRows
from octmip.formats.table.names import check_names
from octmip.formats.table.source import Source

# From 3.1 on pandas reads numbers exactly by default and warns of the option; before, its default may be off.
IS_EXACT = tuple(int(part) for part in pd.__version__.split(".")[:2]) >= (3, 1)
EXACT_NUMBERS: dict[str, Any] = {} if IS_EXACT else {"float_precision": "round_trip"}
QUOTED = re.compile('"[^"]*"')
# A whole cell that is a number: digits and one comma (or one point) among them, between two separators.
DECIMAL = r'(?:^|;)"?[+-]?\d+%s\d+(?:[eE][+-]?\d+)?"?(?=\r?$|;)'
SEPARATORS = {",": "commas", ";": "semicolons", "\t": "tabs"}


def read_delimited(source: Source, as_text: str | None = None) -> pd.DataFrame:
    """Return the table of a CSV or TSV text.

    Commas separate the cells of a CSV; where its header line has none, semicolons or tabs do. With semicolons a number
    may have a decimal comma. The column `as_text`, where there is one, stays as it is written.

    Raises
    ------
    DataError
        the text is no table, a column has no name or one that another has, or decimal commas and points are mixed.
    """
    text = source.text()
    separator = separator_of(text, source.format)
    _check_header(source, text, separator)
    try:
        frame: pd.DataFrame = pd.read_csv(
            io.StringIO(text),
            sep=separator,
            decimal=_decimal(source, text, separator),
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
    if list(frame.columns) != next(_rows(text, separator), []):
        raise DataError(
            f"{source.name}, line 1: the header can be read in two ways; expected plain names; rename the columns"
        )
    return frame


def separator_of(text: str, form: str) -> str:
    """Return what separates the cells: a tab in a TSV; in a CSV the comma, unless the header line has others only."""
    if form == "tsv":
        return "\t"
    header = QUOTED.sub("", text[: text.find("\n") + 1] or text)
    return next((mark for mark in SEPARATORS if mark in header), ",")


def line_of_row(source: Source, row: int) -> int | None:
    """Return the line of the text (1: header) on which a row ends: blank lines hold no row, quoted cells may span."""
    text = source.text()
    rows = _rows(text, separator_of(text, source.format))
    rows_before = -1  # the header
    with contextlib.suppress(csv.Error):  # a cell that pandas takes and csv does not: the row is named by its number
        for cells in rows:
            if cells:
                if rows_before == row:
                    return rows.last
                rows_before += 1
    return None


def _check_header(source: Source, text: str, separator: str) -> None:
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
        raise DataError(
            f"{source.name}, line 2: {len(first)} cells but the header has {len(header)}; name every column"
        )


def _decimal(source: Source, text: str, separator: str) -> str:
    """Return the decimal mark of the numbers: a comma is one only between semicolons."""
    if separator != ";" or not (comma := re.search(DECIMAL % ",", text, re.MULTILINE)):
        return "."
    if point := re.search(DECIMAL % r"\.", text, re.MULTILINE):
        raise DataError(
            f"{source.name} holds numbers with a decimal comma ({comma[0].strip(';')}) and with a decimal point "
            f"({point[0].strip(';')}); expected one of the two; save the table with points"
        )
    return ","


def _rows(text: str, separator: str) -> CsvRows:
    return CsvRows(enumerate(io.StringIO(text, newline=""), start=1), separator=separator)
