"""The table behind a campaign: header and rows as text, with the line numbers that a text editor shows.

Encoding, separators and decimal marks are those of every other table (`octmip.formats.table.delimited`). Lines that
begin with # and empty lines are skipped. A quoted cell may run over several lines;
its row has the number of its first line.
"""

import csv
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from octmip.errors import DataError
from octmip.formats.cells import CsvRows, plain_number
from octmip.formats.table.delimited import Marks, marks_of, ragged
from octmip.formats.table.source import ENDINGS, open_source


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
    source = open_source(path, None if path.suffix.lower() in ENDINGS or path.suffix == ".gz" else "csv")
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
