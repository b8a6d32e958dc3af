"""The top of a table in a text: which line is the header, what stands around it, and where the rows begin."""

import re
from collections.abc import Sequence
from dataclasses import dataclass, replace

from octmip.errors import DataError
from octmip.formats.table.lines import (
    SEPARATORS,
    TAIL,
    Line,
    comment_text,
    is_comment,
    is_value,
    plain_rows,
    split_rows,
    width_of,
)
from octmip.formats.table.units import is_type, is_unit, plain_unit, unit_behind, unit_in
from octmip.input.messages import several

END_OF_HEADER = "***End_of_Header***"
"""Ends what stands before the header in a LabVIEW measurement file."""
CAMPBELL = ("TOA5", "TOACI1")
"""First cell of a table of a Campbell logger, whose next line is the header."""
MOST_ABOVE = 4
"""Rows between a header and its units: serial numbers, ranges, channels."""
LONGEST_UNIT = 12
"""Characters of a word that may be a unit which no table knows."""
RATE = re.compile(r"\d+(?:[.,]\d+)? ?[kM]?Hz")


@dataclass(frozen=True, slots=True)
class Top:
    """The header of a table, and where its rows begin.

    Attributes
    ----------
    header
        (n_columns,) names, "" for a column without one.
    units
        a unit for each name, "" where there is none; none without a row of units.
    line
        number of the header's line.
    first
        number of the line of the first row.
    n_cells
        of a row.
    before, between
        lines without a row before the header, and between it and the first row.
    again
        texts of the header and of the lines around it, which stand again wherever files were joined.
    """

    header: tuple[str, ...]
    units: tuple[str, ...]
    line: int
    first: int
    n_cells: int
    before: tuple[int, ...]
    between: tuple[int, ...]
    again: tuple[str, ...]
    comments: tuple[int, ...]


def top_of(name: str, lines: Sequence[tuple[int, str]], separator: str) -> Top:
    """Return the top of a table in its first lines; `name` is what a sentence calls its source.

    Raises
    ------
    DataError
        no header stands above the rows, or lines before it look like rows of another table.
    """
    rows = plain_rows(name, lines, separator)
    if len(rows) < 2 and sum(is_comment(line, separator) for _, line in lines) > 1 - len(rows):
        rows = _marked_rows(rows, lines, separator)
    if not rows:
        raise DataError(f"{name} is empty: it holds no line but comments; expected a header line and rows; add them")
    start = max((k + 1 for k, row in enumerate(rows) if row.cells[0] == END_OF_HEADER), default=0)
    n_cells = width_of(rows[start:])
    first, numeric = _first_row(rows, start, n_cells)
    number, names, first = _header(name, lines, rows, start, first, n_cells, separator)
    _refuse_row(name, number, names, rows, numeric)
    first = _below_units(rows, number, first, numeric)
    between, first = _between(rows, number, first, len(names), numeric, lines)
    before = [row for row in rows if row.number < number]
    if not start:
        _refuse_tables(name, [line for line in lines if line[0] < number])
    beside = [row.cells for row in (*between, *before[-1:]) if len(row.cells) == len(names)]
    units = next((units for units in map(_units_of, beside) if units), ())
    begin = rows[first].number if first < len(rows) else rows[-1].last + 1
    text_of, used = dict(lines), {k for row in rows for k in range(row.number, row.last + 1)} | {number}
    return Top(
        header=_without_comment(names, n_cells),
        units=units[:n_cells],
        line=number,
        first=begin,
        n_cells=n_cells,
        before=tuple(row.number for row in before),
        between=tuple(row.number for row in between),
        again=tuple(text_of[k].strip() for k in (number, *(row.number for row in (*before, *between))) if k in text_of),
        comments=tuple(k for k, line in lines if k < begin and k not in used and line.strip()),
    )


def _marked_rows(rows: list[Line], lines: Sequence[tuple[int, str]], separator: str) -> list[Line]:
    """Return the rows where all of them begin with the mark of a comment: those of the header's width."""
    top = rows[0].number if rows else 0
    found = list(split_rows([(k, line) for k, line in lines if k >= top], separator))
    return found if rows and all(len(row.cells) == len(rows[0].cells) for row in found) else rows


def is_units(cells: Sequence[str]) -> bool:
    """Whether a row holds units, or nothing, in every cell."""
    return any(cells) and all(not cell or is_unit(cell) or RATE.fullmatch(cell) for cell in cells)


def _has_units(cells: Sequence[str]) -> bool:
    """Whether a row below a header holds units: all, or half of its cells and words beside them, as ms, counts, cm."""
    present = [cell for cell in cells if cell]
    known = [cell for cell in present if is_unit(cell)]
    are_words = all(len(cell) <= LONGEST_UNIT and not is_value(cell) for cell in present)
    is_sure = are_words and any(len(plain_unit(cell)) > 1 for cell in known)
    return is_units(cells) or (is_sure and 2 * len(known) >= len(present))


def _first_row(rows: Sequence[Line], start: int, n_cells: int) -> tuple[int, list[int]]:
    """Return the place of the first row that holds values where most rows do, and the columns of these values."""
    wide = [k for k in range(start, len(rows)) if len(rows[k].cells) == n_cells]
    last = [rows[k].cells for k in wide[-min(TAIL, (len(wide) + 1) // 2) :]]
    numeric = [j for j in range(n_cells) if _holds_values([cells[j] for cells in last])]
    for k in wide if numeric else ():
        cells = [rows[k].cells[j] for j in numeric]
        if 2 * sum(bool(cell) and is_value(cell) for cell in cells) >= len(cells):
            return k, numeric
    return (wide[0] + 1 if wide else start + 1), numeric


def _holds_values(cells: Sequence[str]) -> bool:
    present = [cell for cell in cells if cell]
    return bool(present) and sum(map(is_value, present)) >= 0.8 * len(present)


def _header(
    name: str,
    lines: Sequence[tuple[int, str]],
    rows: Sequence[Line],
    start: int,
    first: int,
    n_cells: int,
    separator: str,
) -> tuple[int, tuple[str, ...], int]:
    """Return the line of the header, its names, and the place of the first row behind it."""
    if rows[0].cells[0] in CAMPBELL and len(rows) > 1:
        return rows[1].number, rows[1].cells, max(first, 2)
    block = [row for row in rows[start:first] if len(row.cells) == n_cells]
    used = [j for j in range(n_cells) if any(len(row.cells) == n_cells and row.cells[j] for row in rows[first:])]
    whole = [row for row in block if _is_whole([row.cells[j] for j in used])]
    if block:
        chosen = (whole or block)[0]
        return chosen.number, chosen.cells, first
    above = rows[first - 1] if first > start else None
    if above is not None and abs(len(above.cells) - n_cells) == 1 and not all(map(is_value, above.cells)):
        return above.number, above.cells, first
    number = rows[first].number if first < len(rows) else 1
    comments = [(k, comment_text(line)) for k, line in lines if k < number and is_comment(line, separator)]
    found = _names_in(comments, separator, n_cells)
    if found is not None:
        return found.number, found.cells, first
    if above is None:  # the names are numbers
        return rows[start].number, rows[start].cells, first + 1
    raise DataError(
        f"{name}, line {number}: rows of {n_cells} cells between {SEPARATORS[separator]} begin here, and the line "
        f"above has {len(above.cells)} cell{'s' * (len(above.cells) != 1)}; expected a header line with a name for "
        "each column above them, and one separator; add it, or give every row as many cells"
    )


def _names_in(comments: Sequence[tuple[int, str]], separator: str, n_cells: int) -> Line | None:
    """Return the last comment with a name for each column; OpenFOAM counts probes there, and names times below."""
    below = ""
    for comment in reversed(comments):
        found = next(split_rows([comment], separator), None)
        if found is None:
            continue
        counted = found.cells[1:] == tuple(map(str, range(n_cells - 1))) and not is_value(found.cells[0])
        if len(found.cells) == n_cells and (counted or not any(map(is_value, found.cells))):
            return replace(found, cells=(below or found.cells[0], *found.cells[1:])) if counted else found
        below = found.cells[0] if len(found.cells) == 1 else ""
    return None


def _is_whole(names: Sequence[str]) -> bool:
    """Whether a row may be a header: a name for each column, none twice, no units."""
    return all(names) and len(set(names)) == len(names) and not is_units(names)


def _refuse_row(name: str, number: int, names: Sequence[str], rows: Sequence[Line], numeric: Sequence[int]) -> None:
    """Refuse a header that is a row: numbers where rows have numbers, and words that stand below it too."""
    below = [row.cells for row in rows if row.number > number and row.cells != names and len(row.cells) == len(names)]
    words = [j for j in range(len(names)) if j not in numeric]
    if (
        words
        and all(j < len(names) and names[j] and is_value(names[j]) for j in numeric)
        and all(any(names[j] == cells[j] for cells in below) for j in words)
    ):
        raise DataError(
            f"{name}, line {number}: the header is a row like those below it, {several(names, 3)}; expected a header "
            "line with a name for each column; put one above it"
        )


def _below_units(rows: Sequence[Line], number: int, first: int, numeric: Sequence[int]) -> int:
    """Return the place of the first row, which stands below a row of units, as those of serial numbers do not."""
    begin = next((k for k, row in enumerate(rows) if row.number > number), len(rows))
    for k in range(min(begin + MOST_ABOVE, len(rows) - 1), begin - 1, -1):
        cells = rows[k].cells
        named = [cells[j] for j in numeric if j < len(cells) and cells[j]]
        rest = "".join(unit_in(cell) for j, cell in enumerate(cells) if j not in numeric)
        are_codes = bool(rest) or max(map(len, named), default=0) < 2  # A, N may be a class and an answer
        is_of_units = named and not any(map(is_value, named)) and is_units(cells)
        if is_of_units and (k == begin or not are_codes):
            return max(first, k + 1)
    return max(first, _below_types(rows, begin) if numeric else first)


def _below_types(rows: Sequence[Line], begin: int) -> int:
    """Return the place below a row that names the type of every column, and below one of roles, as Orange writes."""
    at = begin
    while at < len(rows) and len(rows[at].cells) > 1:
        named = [cell for cell in rows[at].cells if cell or at == begin]
        if not named or not all(map(is_type, named)):
            break
        at += 1
    return at


def _between(
    rows: Sequence[Line],
    number: int,
    first: int,
    n_names: int,
    numeric: Sequence[int],
    lines: Sequence[tuple[int, str]],
) -> tuple[list[Line], int]:
    """Return the rows between header and first row that hold none, and the place of the first that may be one.

    These are units and what stands above them, a word alone, what a Campbell logger made of each column, and whatever
    words stand above an empty line, as HBM's catman writes them, or under units where all columns are of numbers, as
    Origin's comments.
    """
    begin = next((k for k, row in enumerate(rows) if row.number > number), len(rows))
    types = min(first, _below_types(rows, begin) if numeric else begin)
    units = max((k for k in range(begin, first) if _names_units(rows[k].cells, numeric)), default=begin)
    if rows[0].cells[0] in CAMPBELL:
        return list(rows[begin:first]), first
    number_first = rows[first].number if first < len(rows) else 0
    blank = {k for k, line in lines if not line.strip()}
    is_apart = number_first - 1 in blank and first - begin > 1
    for k in range(max(units, types), first):
        cells = rows[k].cells
        is_word = len(cells) == 1 and n_names > 1 and not is_value(cells[0])
        holds_values = any(cells[j] and is_value(cells[j]) for j in numeric if j < len(cells))
        is_of_words = k > units and not any(cell for j, cell in enumerate(cells) if j not in numeric)
        if not (_names_units(cells, numeric) or is_word or ((is_apart or is_of_words) and not holds_values)):
            return list(rows[begin:k]), k
    return list(rows[begin:first]), first


def _units_of(cells: Sequence[str]) -> tuple[str, ...]:
    """Return the units in a row of units, or behind the names of a second header; () in any other row."""
    if _has_units(cells):
        return tuple(map(unit_in, cells))
    names, units = zip(*map(unit_behind, cells), strict=True)
    are_names = not any(name and is_value(name) for name in names)
    return units if are_names and any(units) and all(map(is_unit, units)) else ()


def _names_units(cells: Sequence[str], numeric: Sequence[int]) -> bool:
    """Whether a row is one of units: of numbers where there are such columns, since m is a class too."""
    if not _has_units(cells):
        units = _units_of(cells)
        return any(units[j] for j in numeric if j < len(units))
    return not numeric or any(cells[j] for j in numeric if j < len(cells)) or not any(map(unit_in, cells))


def _without_comment(names: tuple[str, ...], n_cells: int) -> tuple[str, ...]:
    """Return the names without those that no row has a cell for: LabVIEW's comment, or nothing."""
    while len(names) > n_cells and (not names[-1] or names[-1].lower() == "comment"):
        names = names[:-1]
    return names


def _refuse_tables(name: str, lines: Sequence[tuple[int, str]]) -> None:
    """Refuse lines before a header that look like rows of another table: three of one width, most cells values."""
    for separator in SEPARATORS:
        rows = [row for row in plain_rows(name, lines, separator) if row.cells]
        for some in zip(rows, rows[1:], rows[2:], strict=False):
            widths = {len(row.cells) for row in some}
            shares = [sum(bool(c) and is_value(c) for c in row.cells) / len(row.cells) for row in some]
            are_names = len({row.cells[0] for row in some}) == 3 and not any(is_value(row.cells[0]) for row in some)
            if len(widths) == 1 and widths.pop() > 2 and min(shares) > 0.5 and not are_names:
                raise DataError(
                    f"{name}, line {some[0].number}: rows of {len(some[0].cells)} cells between "
                    f"{SEPARATORS[separator]} stand above the header of others; expected one table with one separator; "
                    "give each its own file"
                )
