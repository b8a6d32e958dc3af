"""Text whose cells stand between separators, as `octmip.formats.table.layout` finds them: numbers to the last bit."""

import csv
import functools
import io
import itertools
import re
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import pandas as pd

from octmip.errors import DataError
from octmip.formats.columns.written import ACCOUNTED_ZERO
from octmip.formats.table.layout import Layout, layout_of
from octmip.formats.table.lines import Line, is_value, split_rows
from octmip.formats.table.names import check_names
from octmip.formats.table.source import Source
from octmip.input.cells import is_beyond, may_be_beyond
from octmip.input.messages import several

# From 3.1 on pandas reads numbers exactly by default and warns of the option; before, its default may be off.
IS_EXACT = tuple(int(part) for part in pd.__version__.split(".")[:2]) >= (3, 1)
EXACT_NUMBERS: dict[str, Any] = {} if IS_EXACT else {"float_precision": "round_trip"}
NO_NUMBERS = (
    "",
    "nan",
    "NaN",
    "NAN",
    "-nan",
    "-nan(ind)",
    "nan(ind)",
    "1.#QNAN",
    "-1.#QNAN",
    "1.#IND",
    "-1.#IND",
    "#N/A",
)
"""No class is called so; other words, such as NA, are missing among numbers alone (`octmip.input.cells`)."""
COUNTED = "Unnamed: 0"
"""Name of the column in which pandas read the names of the rows that it had written."""
PADDED = re.compile(r"[+-]?\d+[.,]\d*[1-9]0+")
"""A number with zeros at its end, as 1.10 beside 1.1: they may be codes of two things."""
GROUPED = re.compile(r"[+-]?[1-9]\d{0,2}[.,]\d{3}")
"""A number whose mark may group digits, where all with a mark are so beside whole ones without: 3.000 beside 500."""
MOST_CODES = 100
"""Different numbers of a column that may be codes."""
MOST_WRITTEN = 20_000
"""Rows of a table whose codes are looked at: its cells are read twice for it."""
LONG, PIECE = 1 << 25, 1 << 17
"""Bytes of a text from which it is read in pieces, and rows of a piece."""
FEW = 4
"""Rows whose first cells may count 1, 2, ... by chance."""


def read_delimited(
    source: Source, as_text: str | None, keeps_names: bool = False
) -> tuple[pd.DataFrame, Layout, tuple[str, ...]]:
    """Return the table of a text, its layout, and notes on how it was read.

    The column `as_text`, where there is one, stays as it is written. Names of rows in a first column without a name are
    left out, or with `keeps_names` a column called "".

    Raises
    ------
    DataError
        the text is no table, a row has more or fewer cells than the header, a column has no name or one that another
        has, or decimal commas and points are mixed.
    """
    text, notes = source.text()
    layout = layout_of(source.name, text, source.format)
    del text  # which is as large as its rows
    names = [f"\0{k}" for k in range(layout.n_cells)]
    for k, name in enumerate(layout.header[: layout.n_cells]):
        names[k] = name if name and len(layout.header) == layout.n_cells else names[k]
    check_names(source.name, [name for name in layout.header if name])
    cells = _Cells(layout, tuple(names))
    try:
        frame = _with_whole_numbers(cells.read({} if as_text is None else {as_text: str}), cells)
    except pd.errors.EmptyDataError:
        frame = pd.DataFrame(columns=names)
    except (ValueError, OverflowError) as error:  # pandas' own ParserError among them
        _refuse_ragged(source, layout, is_refused=True)
        reason = str(error).strip().removeprefix("Error tokenizing data. C error: ")
        raise DataError(
            f"{source.name} is no table: {reason}; give every line as many cells as the header has"
        ) from error
    if not isinstance(frame.index, pd.RangeIndex) or (len(frame) and frame.iloc[:, -1].isna().any()):
        _refuse_ragged(source, layout, is_refused=False)  # pandas fills a row that is too short
    codes = _codes(frame, cells)
    frame, told = _named(source, frame, layout, keeps_names)
    frame, padded = without_blanks(frame, NO_NUMBERS)
    return frame, layout, (*notes, *layout.notes, *told, *padded, *codes)


@dataclass(frozen=True, slots=True)
class _Cells:
    """The rows of a layout under names of its columns, as pandas reads them."""

    layout: Layout
    names: tuple[str, ...]

    def read(self, types: Mapping[str, type], columns: Sequence[str] | None = None) -> pd.DataFrame:
        """Return some columns, all by default; those of `types` in these types, the others as pandas finds.

        A long text is read in pieces, which takes half the memory, and again as a whole where a column of one piece
        holds numbers and of another texts.
        """
        chosen: dict[str, Any] = {} if columns is None else {"usecols": list(columns)}
        read: Callable[..., Any] = functools.partial(
            pd.read_csv,
            sep=r"\s+" if self.layout.separator == " " else self.layout.separator,
            decimal=self.layout.decimal,
            **EXACT_NUMBERS,
            header=None,
            names=list(self.names),
            **chosen,
            keep_default_na=False,
            na_values=list(NO_NUMBERS),
            low_memory=False,
            dtype=dict(types),
        )
        text = self.layout.rows.encode()  # StringIO takes four bytes a character
        if len(text) > LONG:
            pieces = list(read(io.BytesIO(text), chunksize=PIECE))
            kinds = ({piece[name].dtype.kind for piece in pieces} for name in pieces[0])
            if all(len(kind) == 1 or kind == {"i", "f"} for kind in kinds):
                together: pd.DataFrame = pd.concat(pieces)
                return together
        frame: pd.DataFrame = read(io.BytesIO(text))
        return frame


def _with_whole_numbers(frame: pd.DataFrame, cells: _Cells) -> pd.DataFrame:
    """Return the table with the texts of columns where float64, for the sake of an empty cell, merges whole numbers."""
    large = [name for name in cells.names if frame[name].dtype.kind == "f" and may_be_beyond(frame[name])]
    if not large:
        return frame
    texts = cells.read(dict.fromkeys(large, str), large)
    return frame.assign(**{name: texts[name] for name in large if texts[name].map(is_beyond).any()})


def _codes(frame: pd.DataFrame, cells: _Cells) -> tuple[str, ...]:
    """Return a sentence on each column in which two texts are one number, or whose mark may group digits."""
    floats = [k for k in cells.names if not k.startswith("\0") and frame[k].dtype.kind == "f"]
    few = [k for k in floats if 0 < frame[k].nunique() <= MOST_CODES] if len(frame) <= MOST_WRITTEN else []
    texts = cells.read(dict.fromkeys(few, object), few) if few else frame[few]
    told = []
    for name in few:
        found = set(texts[name].dropna())
        padded = sorted(text for text in found if PADDED.fullmatch(text) and text.rstrip("0") in found)
        if padded:
            pair = f"{padded[0].rstrip('0')} and {padded[0]} in column {name!r}"
            told.append(f"{pair} are one number; where they are codes of two things, write words")
        marked = sorted(text for text in found if not text.lstrip("+-").isdigit())
        if 0 < len(marked) < len(found) and all(map(GROUPED.fullmatch, marked)):
            told.append(f"{marked[0]} in column {name!r} has decimals; where its mark groups digits, leave it out")
    return tuple(told)


def without_blanks(frame: pd.DataFrame, missing: Collection[str] = ()) -> tuple[pd.DataFrame, tuple[str, ...]]:
    """Return the table whose texts have no blanks at their ends, as programs write that align columns, and a note.

    Texts that are in `missing` without blanks are missing cells.
    """
    padded = []
    for name in frame.columns:
        column = frame[name]
        is_bare = isinstance(column.dtype, pd.StringDtype) and bool((column.str.strip() == column).fillna(True).all())
        has_none = column.dtype.kind in "biufmM" or is_bare or isinstance(column.dtype, pd.CategoricalDtype)
        texts: set[str] = set() if has_none else {cell for cell in column if isinstance(cell, str)}
        bare = {text: text.strip() for text in texts if text != text.strip()}
        if bare:
            words: dict[Any, Any] = {text: None if word in missing else word for text, word in bare.items()}
            if any(char.isdigit() for text in texts for char in text):
                words |= {text: "0" for text in bare if ACCOUNTED_ZERO.fullmatch(text)}
            cells: list[Any] = [words.get(cell, cell) if isinstance(cell, str) else cell for cell in column]
            frame = frame.assign(**{name: cells})
            padded.append(name)
    told = f"blanks at the ends of texts are left out: {several(padded)}"
    return frame, (told,) * bool(padded)


def rows_in(layout: Layout, strict: bool = False) -> Iterator[Line]:
    """Return the rows of a layout, with their lines."""
    return split_rows(enumerate(io.StringIO(layout.rows, newline=""), start=1), layout.separator, strict)


def _refuse_ragged(source: Source, layout: Layout, is_refused: bool) -> None:
    """Refuse a row of another length than most, or (where pandas refused it) a quotation mark that is not closed."""
    n_columns, last = layout.n_cells, layout.line
    try:
        for row in rows_in(layout, strict=is_refused):
            last = row.last
            if len(row.cells) != n_columns:
                raise DataError(f"{source.name}, line {row.number}: {ragged(len(row.cells), n_columns)}")
    except csv.Error as error:
        raise DataError(
            f"{source.name}, line {last + 1} or below is not valid CSV ({error}); close its quotation mark or remove it"
        ) from error


def ragged(n_cells: int, n_columns: int) -> str:
    """Return what is wrong with a row of another length than the header, behind its place."""
    return (
        f"{n_cells} cell{'s' * (n_cells != 1)} but the header has {n_columns}; give every row one for each column, an "
        "empty one where nothing is known, or begin the line with # if it is none"
    )


def _named(
    source: Source, frame: pd.DataFrame, layout: Layout, keeps_names: bool
) -> tuple[pd.DataFrame, tuple[str, ...]]:
    """Return the frame under the names of its header, without columns that only end the lines or name the rows."""
    header, columns = list(layout.header), list(frame.columns)
    place = f"{source.name}, line {layout.line}"
    empty = [k for k, name in enumerate(columns) if frame[name].isna().all()]
    while columns and len(columns) - 1 in empty and (len(header) < len(columns) or not header[len(columns) - 1]):
        columns.pop()  # a separator at the end of every line
    frame = frame[columns]
    header = header if any(header[len(columns) :]) else header[: len(columns)]
    if len(header) == len(columns):  # an empty column, as before the first bar of a line in bars
        held = [k for k, name in enumerate(header) if name or k not in empty]
        header, columns = [header[k] for k in held], [columns[k] for k in held]
        frame = frame[columns]
    if len(header) < len(columns) - 1 or len(header) > len(columns):
        row = next(rows_in(layout), None)
        if row is not None:
            raise DataError(f"{source.name}, line {row.number}: {ragged(len(row.cells), len(layout.header))}")
    if len(header) == len(columns) - 1:
        return _with_first(source, frame, layout, header, keeps_names)
    frame = frame.set_axis(header, axis=1)  # which had no names beside an empty last column
    unnamed = [k for k, name in enumerate(header) if not name]
    if header and header[0].startswith(COUNTED):
        unnamed = [0, *unnamed]
    if keeps_names and unnamed == [0]:
        return frame, ()
    if unnamed == [0] and len(columns) > 1 and frame.iloc[:, 0].is_unique:
        return frame.iloc[:, 1:], (f"the first column of {source.name} has no name; it names the rows and is left out",)
    unnamed = [k for k in unnamed if not header[k]]
    if unnamed:
        raise DataError(f"{place}: column {unnamed[0] + 1} has no name; name it, or drop it if it only counts the rows")
    return frame, ()


def _with_first(
    source: Source, frame: pd.DataFrame, layout: Layout, header: list[str], keeps_names: bool
) -> tuple[pd.DataFrame, tuple[str, ...]]:
    """Return the frame whose rows have a cell before the first name: names of rows, or a day before its time."""
    first = frame.iloc[:, 0]
    row = next(rows_in(layout))
    if layout.separator == " " and is_value(joined := f"{row.cells[0]} {row.cells[1]}") and ":" in joined:
        both = first.astype(str) + " " + frame.iloc[:, 1].astype(str)
        out = pd.concat([both, frame.iloc[:, 2:]], axis=1)
        return out.set_axis(header, axis=1), (f"day and time are read together as the column {header[0]}",)
    lines = io.StringIO(layout.rows, newline="")
    begin = next(itertools.islice(lines, row.number - 1, None)).lstrip()[:1]
    counts = first.dtype.kind == "i" and first.tolist()[:1] in ([0], [1]) and bool((first.diff()[1:] == 1).all())
    counts = counts and (layout.separator != "," or len(first) > FEW)  # 1,5 may be a number with a decimal comma
    if not (first.is_unique and (begin == '"' or not is_value(row.cells[0]) or counts)):
        raise DataError(
            f"{source.name}, line {row.number}: {ragged(len(row.cells), len(header))}, and name every column"
        )
    if keeps_names:
        return frame.set_axis(["", *header], axis=1), ()
    out = frame.iloc[:, 1:].set_axis(header, axis=1)
    return out, (f"the rows of {source.name} have names, as R and pandas write them, which are left out",)
