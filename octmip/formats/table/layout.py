"""Where the table stands in a text that a logger or a spreadsheet wrote, and what stands around it.

1. the separator under which the last rows have one width, and the decimal mark
2. the first row that holds numbers where most rows do
3. the header, above it, with the rows between them that are units
4. what is no row: lines before the header, comments, the header again where files were joined, words after the end

What is left out is said. A line that may be a row and may be none is refused. Lines that hold no row become empty, so
that every other line keeps its number.
"""

import io
import re
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

from octmip.errors import DataError
from octmip.formats.table.joined import in_one_order
from octmip.formats.table.left_out import rows_of
from octmip.formats.table.lines import SEPARATORS, TAIL, is_value, plain_rows, width_of
from octmip.formats.table.top import Top, top_of
from octmip.input.cells import plain_number

HEAD = 500
"""Lines in which the header is looked for."""
# A whole cell that is a number: digits and one comma (or one point) among them, between two separators.
DECIMAL = r'(?:^|%s)[ ]*"?[+-]?\d+%s\d+(?:[eE][+-]?\d+)?"?[ ]*(?=\r?$|%s)'
SURE = r'(?:^|%s)[ ]*"?[+-]?(?:0\d*,\d+|\d+,\d{1,2}|\d+,\d{4,}|\d+,\d+[eE][+-]?\d+)"?[ ]*(?=\r?$|%s)'
"""A decimal comma: no group of three digits follows it, or nothing but a zero stands before it."""


@dataclass(frozen=True, slots=True)
class Layout:
    """A table in a text.

    Attributes
    ----------
    separator
        of cells, one of `SEPARATORS`.
    decimal
        mark of the numbers.
    header
        a name for each cell of a row, spaces stripped; "" for a column without one.
    units
        a unit for each column, "" where none is written; none where the text has no row of them.
    line
        number of the header's line.
    n_cells
        of a row.
    rows
        the text with every line empty that holds no row.
    notes
        sentences on what was left out and how the rest is read.
    """

    separator: str
    decimal: str
    header: tuple[str, ...]
    units: tuple[str, ...]
    line: int
    n_cells: int
    rows: str
    notes: tuple[str, ...]


def layout_of(name: str, text: str, form: str) -> Layout:
    """Return the layout of a text; `name` is what a sentence calls its source, `form` is "csv" or "tsv".

    Raises
    ------
    DataError
        no header stands above the rows, a line may be a row and may be none, or decimal commas and points are mixed.
    """
    excel = re.match(r'"?sep=([,;|\t])"?\r?\n', text, re.IGNORECASE)  # which Excel reads
    lines = [(k, line) for k, line in _head(text) if k > 1 or not excel]
    separator = excel[1] if excel else _separator(name, lines, form)
    top = top_of(name, lines, separator)
    decimal = _decimal(name, text, separator)
    notes = (f"numbers are read with decimal commas, as the cells stand between {SEPARATORS[separator]}",)
    text, joined = in_one_order(name, text, top, separator)
    rows, left_out = rows_of(name, text, top, separator)
    told = (*left_out, *joined, *_numbers_as_names(top), *notes * (decimal == ","))
    return Layout(separator, decimal, top.header, top.units, top.line, top.n_cells, rows, told)


def _numbers_as_names(top: Top) -> tuple[str, ...]:
    """Return a sentence on names that are numbers, unless they count: the header may be a row."""
    numbers = [number for name in top.header if (number := plain_number(name)) is not None]
    if not numbers or all(b - a == 1.0 for a, b in pairwise(numbers)):
        return ()
    return (f"names in line {top.line} are numbers; if it is a row, put a line with names above it",)


def _head(text: str) -> list[tuple[int, str]]:
    """Return the first lines with their numbers."""
    at = 0
    for _ in range(HEAD):
        at = text.find("\n", at) + 1
        if not at:
            break
    return list(enumerate(io.StringIO(text[:at] if at else text, newline=""), start=1))


def _separator(name: str, lines: Sequence[tuple[int, str]], form: str) -> str:
    """Return the separator under which most rows have the width of the last ones, and most cells are values."""
    if form == "tsv":
        return "\t"
    best, chosen = (0, 0.0, 0), ","
    for separator in SEPARATORS:
        if separator == " " and best[0]:
            break  # blanks stand in cells too
        rows = plain_rows(name, lines, separator)
        width = width_of(rows)
        same = [row for row in rows if len(row.cells) == width]
        cells = [cell for row in same[-TAIL:] for cell in row.cells]
        score = (len(same), sum(map(is_value, cells)) / max(1, len(cells)), width)
        if width > 1 and score > best:
            best, chosen = score, separator
    return chosen


def _decimal(name: str, text: str, separator: str) -> str:
    """Return the decimal mark of the numbers: a comma is none where commas separate the cells."""
    if separator == "," or "," not in text:
        return "."
    mark = r"\s" if separator == " " else re.escape(separator)
    comma = re.search((DECIMAL % (mark, ",", mark)) if separator == ";" else SURE % (mark, mark), text, re.MULTILINE)
    if comma is None:
        return "."
    point = re.search(DECIMAL % (mark, r"\.", mark), text, re.MULTILINE)
    if point and separator == ";":
        strip = f'{separator} \t\n"'
        raise DataError(
            f"{name} holds numbers with a decimal comma ({comma[0].strip(strip)}) and with a decimal point "
            f"({point[0].strip(strip)}); expected one of the two; save the table with points"
        )
    return "." if point else ","  # a column of its own may have commas: `octmip.formats.columns.written`
