"""Files that were joined although the later ones name their columns in another order: one order, that of the first."""

import csv
import io
from collections.abc import Iterator, Sequence

from octmip.errors import DataError
from octmip.formats.table.lines import Line, split_rows
from octmip.formats.table.top import Top, is_units
from octmip.formats.table.units import unit_in


def in_one_order(name: str, text: str, top: Top, separator: str) -> tuple[str, tuple[str, ...]]:
    """Return a text whose later parts have the columns of its header in its order, and a sentence where some had not.

    A header there is that of the top, and so are units below it that are the same. Every line keeps its number.

    Raises
    ------
    DataError
        a later part names other units.
    """
    longest = max(top.header, key=len, default="")
    if len(set(top.header)) < 2 or not longest or separator == " " or text.count(longest) < 2:
        return text, ()
    lines = text.split("\n")
    try:
        parts = _in_one_order(name, lines, top, separator, longest)
    except csv.Error:  # whoever reads the rows says what is wrong
        return text, ()
    where = ", ".join(str(k + 1) for k in parts)
    told = (f"columns stand in another order below line {where}, and are matched by their names",)
    return "\n".join(lines), told * bool(parts)


def _in_one_order(name: str, lines: list[str], top: Top, separator: str, longest: str) -> list[int]:
    """Bring the lines into one order, in place, and return where the headers of other orders stand."""
    wanted, first = sorted(top.header), top.again[0]
    likely = [k for k in range(top.first - 1, len(lines)) if longest in lines[k] and lines[k].strip() != first]
    parts = [k for k in likely if _cells(lines[k], separator) == wanted]
    for begin, stop in _spans(parts, lines, top, longest):
        names = next(split_rows([(0, lines[begin])], separator)).cells
        order = [names.index(own) for own in top.header]
        rows = list(split_rows(enumerate(lines[begin + 1 : stop], start=begin + 1), separator))
        if rows and is_units(rows[0].cells) and len(rows[0].cells) == len(order):
            _refuse_units(name, tuple(unit_in(rows[0].cells[k]) for k in order), rows[0], top)
            lines[rows[0].number], rows = "", rows[1:]
        lines[begin] = first
        for row in rows:
            lines[row.number : row.last + 1] = _written(row, order, separator).split("\n")
    return parts


def _cells(line: str, separator: str) -> list[str]:
    return sorted(next((row.cells for row in split_rows([(0, line)], separator)), ()))


def _spans(parts: Sequence[int], lines: Sequence[str], top: Top, longest: str) -> Iterator[tuple[int, int]]:
    """Yield where each part begins and ends: at the next header of any order."""
    if not parts:
        return
    same = [k for k in range(parts[0], len(lines)) if longest in lines[k] and lines[k].strip() == top.again[0]]
    ends = sorted({*parts, *same, len(lines)})
    for begin in parts:
        yield begin, next(k for k in ends if k > begin)


def _written(row: Line, order: Sequence[int], separator: str) -> str:
    """Return a row with its cells in an order; one of another length stays, and is refused as such."""
    cells = [row.cells[k] for k in order] if len(row.cells) == len(order) else row.cells
    buffer = io.StringIO()
    csv.writer(buffer, delimiter=separator, lineterminator="").writerow(cells)
    return buffer.getvalue()


def _refuse_units(name: str, units: tuple[str, ...], row: Line, top: Top) -> None:
    if units != top.units:
        raise DataError(
            f"{name}, line {row.number + 1}: the units of the columns are others than under the first header; expected "
            "one unit a column; convert the rows below, or give each part its own file"
        )
