"""The rows of a text, without what stands between and after them: comments, the header again, words at the end."""

import re
from collections.abc import Iterable, Iterator, Sequence

from octmip.errors import DataError
from octmip.formats.table.lines import RULE, TAIL, comment_text, is_comment, is_value, split_rows
from octmip.formats.table.top import Top, is_units
from octmip.formats.table.units import unit_in
from octmip.input.messages import shown

MARKS = ("#", "%", "//", ";")
"""What a line of comment begins with."""
MOST_SAID = 6
"""Numbers of lines that a sentence names."""
Span = tuple[int, int]
"""Where a line begins and ends in a text."""


def rows_of(name: str, text: str, top: Top, separator: str) -> tuple[str, tuple[str, ...]]:
    """Return a text in which every line without a row is empty, and a sentence on what was left out.

    Raises
    ------
    DataError
        a line begins as a comment but has as many cells as a row.
    """
    start = _offset(text, top.first)
    body = text[start:] if start else text
    again = list(_again(body, top))
    _refuse_other_units(name, body, top, again, separator)
    comments = [span for span in _comments(name, body, top, separator) if span not in again]
    end = list(_after_the_end(body, top, separator))
    pieces, at = ["\n" * (top.first - 1)], 0
    for begin, stop in sorted({*comments, *again, *end}):
        pieces.append(body[at:begin])
        at = stop
    pieces.append(body[at:])
    parts = [
        _lines("above the header", top.before),
        *_between(top),
        _lines("of comment", (*top.comments, *(_number(body, top, span) for span in comments))),
        _lines("with the header again", [_number(body, top, span) for span in again]),
        *(f"{shown(body[a:b].strip())} after the last row" for a, b in end[::-1]),
    ]
    said = "; ".join(part for part in parts if part)
    return "".join(pieces), (f"no rows and left out: {said}",) * bool(said)


def _refuse_other_units(name: str, body: str, top: Top, again: Sequence[Span], separator: str) -> None:
    """Refuse a header that stands again above other units: its rows would be read in those of the first."""
    for _, stop in again:
        end = _end(body, stop + 1)
        line, below = body[stop + 1 : end], body[end + 1 : _end(body, end + 1)]
        pair = [row.cells for row in split_rows([(1, line), (2, below)], separator) if len(row.cells) == top.n_cells]
        if line.strip() in (*top.again, body[: _end(body, 0)].strip()) or len(pair) < 2 or not is_units(pair[0]):
            continue
        named = [is_value(number) for unit, number in zip(*pair, strict=True) if unit_in(unit)]
        if named and all(named):  # m and A may be classes, but not above numbers
            first = f"those of line {top.between[-1]}" if top.between else "none, as above"
            raise DataError(
                f"{name}, line {_number(body, top, (stop + 1, 0))}: the header stands again with the units "
                f"{shown(line.strip())}; expected {first}; give each table its own file"
            )


def _lines(what: str, numbers: Sequence[int]) -> str:
    """Return lines by their numbers, "" where there are none."""
    if not numbers:
        return ""
    if len(numbers) > 2 and numbers[-1] - numbers[0] == len(numbers) - 1:
        return f"lines {numbers[0]} to {numbers[-1]} {what}"
    more = f" and {len(numbers) - MOST_SAID} more" if len(numbers) > MOST_SAID else ""
    return f"line{'s' * (len(numbers) > 1)} {', '.join(map(str, numbers[:MOST_SAID]))}{more} {what}"


def _between(top: Top) -> Iterator[str]:
    where = _lines("under the header", top.between)
    named = ", ".join(f"{name} {unit}" for name, unit in zip(top.header, top.units, strict=False) if unit)
    yield f"{where or 'of these one'} with the units ({shown(named)[1:-1]})" if named else where


def _offset(text: str, number: int) -> int:
    """Return where a line begins."""
    at = 0
    for _ in range(number - 1):
        at = text.find("\n", at) + 1
        if not at:
            return len(text)
    return at


def _number(body: str, top: Top, span: Span) -> int:
    return top.first + body.count("\n", 0, span[0])


def _lines_with(body: str, beginning: str) -> Iterator[Span]:
    """Yield every line but the first that begins so and begins within no quoted cell."""
    at, quotes, counted = body.find("\n" + beginning), 0, 0
    while at >= 0:
        quotes, counted = quotes + body.count('"', counted, at), at
        stop = _end(body, at + 1)
        if quotes % 2 == 0:
            yield at + 1, stop
        at = body.find("\n" + beginning, stop)


def _end(body: str, begin: int) -> int:
    stop = body.find("\n", begin)
    return len(body) if stop < 0 else stop


def _comments(name: str, body: str, top: Top, separator: str) -> Iterator[Span]:
    if is_comment(body[: _end(body, 0)], separator):  # so do rows begin
        return
    for mark in MARKS:
        if mark[0] not in body:  # much quicker to see than where a line begins with it
            continue
        for span in _lines_with(body, mark):
            line = body[slice(*span)].rstrip("\r")
            if is_comment(line, separator) and line.strip() not in top.again:
                _refuse_doubt(name, line, _number(body, top, span), top.n_cells, separator)
                yield span


def _refuse_doubt(name: str, line: str, number: int, n_cells: int, separator: str) -> None:
    """Refuse a comment that may be a row."""
    row = next(split_rows([(1, comment_text(line))], separator), None)
    if row is not None and len(row.cells) == n_cells:
        raise DataError(
            f"{name}, line {number} begins with {shown(line[:2])} as a comment does, but has as many cells as a row "
            f"({n_cells}); expected one or the other; delete the line, or write its first cell in quotation marks"
        )


def _again(body: str, top: Top) -> Iterator[Span]:
    """Yield the lines of a header that stands again, and those around it that stood around the first one."""
    header, around = top.again[0], top.again[1:]
    for begin, stop in _lines_with(body, header):
        if body[begin:stop].strip() != header:
            continue
        yield begin, stop
        before = begin
        while before > 0:
            above = (body.rfind("\n", 0, before - 1) + 1, before - 1)
            if body[slice(*above)].strip() not in around:
                break
            yield above
            before = above[0]
        while stop < len(body):
            below = (stop + 1, _end(body, stop + 1))
            if body[slice(*below)].strip() not in around:
                break
            yield below
            stop = below[1]


def _after_the_end(body: str, top: Top, separator: str) -> Iterator[Span]:
    """Yield the last lines of words where rows have more cells: one word, or several without a number."""
    if top.n_cells < 2:
        return
    begun: Iterable[str] | None = None
    stop = len(body)
    for _ in range(TAIL):
        while stop and body[stop - 1].isspace():
            stop -= 1
        begin = body.rfind("\n", 0, stop) + 1
        line = body[begin:stop]
        if not begin or line.count('"') % 2 or body.count('"', 0, begin) % 2:
            return
        if RULE.fullmatch(line):
            yield begin, stop
            stop = begin - 1
            continue
        row = next(split_rows([(1, line)], separator), None)
        if row is None or not _is_word(row.cells, top.n_cells, separator):
            return
        if begun is None:
            some = body[max(0, begin - 10_000) : begin].split("\n")[1:]
            rows = split_rows(enumerate(some), separator)
            begun = {one.cells[0] for one in rows if len(one.cells) == top.n_cells}
        if any(cell.startswith(row.cells[0]) for cell in begun):  # a row that was cut
            return
        yield begin, stop
        stop = begin - 1


def _is_word(cells: Sequence[str], n_cells: int, separator: str) -> bool:
    is_single = len([cell for cell in cells if cell]) == 1 and len(cells) < n_cells
    are_words = separator == " " and len(cells) < n_cells
    return (is_single or are_words) and all(
        re.search(r"[^\W\d]{2}", cell) is not None and not is_value(cell) for cell in cells if cell
    )
