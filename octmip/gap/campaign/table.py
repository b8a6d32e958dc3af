"""The table behind a campaign: header and rows as text, with the line numbers that a text editor shows.

Comma-separated UTF-8. Lines that begin with # and empty lines are skipped. A quoted cell may run over several lines;
its row has the number of its first line.
"""

import csv
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from octmip.errors import DataError
from octmip.formats.cells import CsvRows, plain_number

OTHER_SEPARATORS = {";": "semicolons", "\t": "tabs", "|": "bars"}


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
    """

    header: tuple[str, ...]
    header_number: int
    rows: tuple[tuple[str, ...], ...]
    numbers: tuple[int, ...]

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
        return np.array([_number(text, k, name) for text, k in zip(self.texts(name), self.numbers, strict=True)])


def read_campaign_table(path: str | Path) -> CampaignTable:
    """Return the table in a campaign's file.

    Raises
    ------
    DataError
        no such file, not UTF-8, nothing in it, another separator, a row with more or fewer cells than the
        header.
    """
    path = Path(path)
    rows = list(_parsed(_text(path)))
    if not rows:
        raise DataError(
            f"campaign file {path} is empty (lines that begin with # are comments); expected a header row and one row "
            "per reading; export the table again"
        )
    (number, head), body = rows[0], rows[1:]
    header = tuple(name.strip() for name in head)
    while len(header) > 1 and not header[-1] and all(len(r) == len(head) and not r[-1].strip() for _, r in body):
        header, head = header[:-1], head[:-1]
        body = [(k, row[:-1]) for k, row in body]  # a comma at the end of every line
    _refuse_separator(header, number)
    if not body:
        raise DataError(
            f"campaign file {path} has a header in row {number} and no reading (lines that begin with # are comments); "
            "expected one row per reading; add the readings"
        )
    for k, row in body:
        if len(row) != len(header):
            raise DataError(_ragged(k, row, len(header)))
    return CampaignTable(header, number, tuple(tuple(row) for _, row in body), tuple(k for k, _ in body))


def _text(path: Path) -> str:
    if not path.is_file():
        raise DataError(f"campaign file {path} is not there; expected a CSV file; check the path")
    try:
        return path.read_text(encoding="utf-8-sig")
    except UnicodeDecodeError as error:
        raise DataError(f"campaign file {path} is not UTF-8 text ({error}); save it as CSV in UTF-8") from error
    except OSError as error:
        raise DataError(f"campaign file {path} cannot be read ({error.strerror}); expected a readable file") from error


def _parsed(text: str) -> Iterator[tuple[int, list[str]]]:
    """Yield each row with the number of its first line."""
    rows = CsvRows(_content(text), strict=True)
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


def _refuse_separator(header: tuple[str, ...], number: int) -> None:
    found = next((mark for mark in OTHER_SEPARATORS if len(header) == 1 and mark in header[0]), None)
    if found is not None:
        raise DataError(
            f"row {number} (header): columns are separated by {OTHER_SEPARATORS[found]}; expected commas, and points "
            "in decimal numbers; save the table as comma-separated CSV"
        )


def _ragged(number: int, row: list[str], expected: int) -> str:
    other = next((words for mark, words in OTHER_SEPARATORS.items() if len(row) < expected and mark in row[0]), None)
    hint = f"it is separated by {other}; use commas in every row" if other else "complete the row"
    return f"row {number} has {len(row)} columns but the header has {expected}; {hint}"


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
