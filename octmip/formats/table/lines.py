"""The lines of a text as rows of cells, and which of them are comments."""

import csv
import re
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

from octmip.errors import DataError
from octmip.formats.columns.times import is_time_text
from octmip.input.cells import CsvRows, is_missing_word, plain_number

SEPARATORS = {",": "commas", ";": "semicolons", "\t": "tabs", "|": "bars", " ": "blanks"}
TAIL = 50
"""Rows, the last of some, that show what a column holds; most lines of words after the last row."""
COMMENT = re.compile(r"\s*(?:#|%|//)")
RULE = re.compile(r"(?=(?:[^-=]*[-=]){3})[-=+|:\s]+")
"""A line drawn above or under a header, or under the last row."""


@dataclass(frozen=True, slots=True)
class Line:
    """A row of cells of a text.

    Attributes
    ----------
    number, last
        of its first line and its last, from 1.
    cells
        spaces stripped.
    """

    number: int
    last: int
    cells: tuple[str, ...]


def split_rows(lines: Iterable[tuple[int, str]], separator: str, strict: bool = False) -> Iterator[Line]:
    """Yield the rows of numbered lines that are not empty; `strict` as `CsvRows` has it.

    Raises
    ------
    csv.Error
        a cell is longer than any may be, or a quotation mark is not closed.
    """
    reader = CsvRows(lines, strict=strict, separator=separator)
    for cells in reader:
        stripped = tuple(cell.strip() for cell in cells)
        if separator == " ":
            stripped = tuple(cell for cell in stripped if cell)
        if len(stripped) > 1 or any(stripped):
            yield Line(reader.first, reader.last, stripped)


def is_comment(line: str, separator: str) -> bool:
    """Whether a line begins with the mark of a comment, and not with what Excel writes of an error."""
    first = line.lstrip().split(separator, 1)[0]
    if first.startswith("#") and is_missing_word(first):
        return False
    return bool(COMMENT.match(line)) or (separator != ";" and line.lstrip().startswith(";"))


def plain_rows(name: str, lines: Sequence[tuple[int, str]], separator: str) -> list[Line]:
    """Return the rows of lines that are no comments."""
    kept = [(k, line) for k, line in lines if not (is_comment(line, separator) or RULE.fullmatch(line))]
    try:
        return list(split_rows(kept, separator))
    except csv.Error as error:
        # The row that could not be read begins behind the last that could.
        number = _last_read(kept, separator)
        cells = f"cells separated by {SEPARATORS[separator]}"
        raise DataError(f"{name}, line {number}: {error}; expected {cells}") from error


def _last_read(lines: Sequence[tuple[int, str]], separator: str) -> int:
    reader = CsvRows(lines, separator=separator)
    try:
        for _ in reader:
            pass
    except csv.Error:
        pass
    return reader.last


def width_of(rows: Sequence[Line]) -> int:
    """Return the width of the last rows: that of the last two neighbours of one width; no word alone is one."""
    widths = [len(row.cells) for row in rows if len(row.cells) > 1 or not _is_word(row.cells[0])]
    widths = widths or [len(row.cells) for row in rows]
    pairs = (a for a, b in zip(widths[::-1], widths[-2::-1], strict=False) if a == b)
    return next(pairs, widths[-1] if widths else 0)


def _is_word(cell: str) -> bool:
    """Whether a line of one cell is words: no value, and no row between other separators."""
    return not is_value(cell) and not any(mark in cell for mark in SEPARATORS if mark != " ")


def comment_text(line: str) -> str:
    """Return what a line of comment says."""
    return COMMENT.sub("", line).strip("# ;\r\n")


def is_value(cell: str) -> bool:
    """Whether a cell is a number, a time, or says that there is none."""
    if not cell or is_missing_word(cell):
        return True
    if not any(c.isdigit() for c in cell):
        return False
    return plain_number(cell.replace(",", ".", 1)) is not None or is_time_text(cell)
