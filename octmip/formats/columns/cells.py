"""The cells of one column of a table: numbers, or texts, and which of them are missing.

Numbers that a file keeps as text ("5.5", "?") are numbers again, with words such as "?" among them missing. So are
dates, per cent and amounts as people write them (`octmip.formats.columns.written`).
"""

import math
from dataclasses import dataclass, replace
from datetime import date, time, timedelta
from decimal import Decimal
from typing import Any, Literal

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from octmip.errors import DataError
from octmip.formats.columns.instants import zone_of
from octmip.formats.columns.spellings import DAYS, ISO
from octmip.formats.columns.times import days_in, read_times, zone_in
from octmip.formats.columns.written import form_of, is_date, read_texts, unit_of, words_of
from octmip.input.cells import BEYOND, beyond_exact, is_beyond, is_missing_word, plain_number, truths_in
from octmip.input.messages import MOST_NAME, shown

UNKNOWN = "?"
"""Missing among texts too, as no value is called so; "NA" or "none" may be one."""
KINDS = (str, int, float, Decimal, np.number, np.bool_)
Stored = Literal["numbers", "texts", "truths"]
"""What the cells of a column are in its table: numbers or times, texts (numbers among words too), or Booleans."""
DATE_CELLS = (date, np.datetime64, pd.Period)
DURATION_CELLS = (timedelta, np.timedelta64)


@dataclass(frozen=True, slots=True, eq=False)
class Cells:
    """The cells of one column.

    Attributes
    ----------
    numbers
        (n_rows,) float64, NaN where missing; NaN everywhere in a column of texts.
    words
        (n_rows,) the texts as objects, None where missing; None everywhere in a column of numbers.
    values
        the different texts in their order; none in a column of numbers.
    is_ordered
        whether the texts have an order of their own (a pandas category).
    n_missing
        number of missing cells.
    form
        how the numbers were written (`octmip.formats.columns.written`), "" for plain numbers and texts.
    zone
        of the clock that dates were read from (`octmip.formats.columns.instants.date_text`).
    stored
        what they are in the table: numbers of "truths" are true (1) and false (0).
    """

    numbers: NDArray[np.float64]
    words: NDArray[Any]
    values: tuple[str, ...]
    is_ordered: bool
    n_missing: int
    form: str = ""
    zone: str = ""
    stored: Stored = "numbers"

    @property
    def is_text(self) -> bool:
        """Whether the column holds texts."""
        return len(self.values) > 0


def read_cells(series: "pd.Series[Any]", form: str | None = None) -> Cells:
    """Return the cells of a column; with the `form` of training ("": plain) they are read in that one alone.

    Raises
    ------
    DataError
        a cell is neither a number, true or false, a date, nor a text, no float64 holds it, or it has another form; the
        sentence begins behind the name of the column.
    """
    is_missing = series.isna().to_numpy(dtype=bool)
    cells = replace(_cells_of(series, is_missing, form), stored=_stored_as(series))
    if form is not None and unit_of(cells.form) != unit_of(form) and cells.n_missing < len(series):
        found = shown(cells.values[0]) if cells.is_text else f"the number {np.nanmin(cells.numbers):g}"
        got = f"{words_of(cells.form)}" if cells.form else found
        raise DataError(f"holds {got}; expected {words_of(form)}, as in training; write it so")
    return cells


def _stored_as(series: "pd.Series[Any]") -> Stored:
    """Return what the cells of a column are in its table, whatever is read from them."""
    if isinstance(series.dtype, pd.CategoricalDtype):
        return _stored_as(series.cat.categories.to_series())
    if series.dtype.kind == "b":
        return "truths"
    present = series[series.notna()] if series.dtype.kind not in "iufcmM" else ()
    if any(isinstance(cell, str) for cell in present):
        return "truths" if truths_in(present) else "texts"
    return "truths" if len(present) and all(isinstance(cell, bool | np.bool_) for cell in present) else "numbers"


def _cells_of(series: "pd.Series[Any]", is_missing: NDArray[np.bool_], form: str | None) -> Cells:
    kind = series.dtype.kind
    if isinstance(series.dtype, pd.CategoricalDtype):
        return _categories(series, is_missing)
    if isinstance(series.dtype, pd.PeriodDtype) or kind == "M":
        return _dates(series, is_missing)
    if kind == "m":
        return _durations(series, is_missing)
    if kind == "c":
        raise DataError("holds complex numbers; give real and imaginary parts as two columns")
    if kind in "biuf":
        return _numbers(_exact(series, is_missing), is_missing)
    return _objects(series, is_missing, form)


def _numbers(numbers: NDArray[np.float64], is_missing: NDArray[np.bool_], form: str = "", zone: str = "") -> Cells:
    infinite = np.flatnonzero(np.isinf(numbers))
    if len(infinite):
        raise DataError(f"is {numbers[infinite[0]]:g} in row {infinite[0] + 1}; expected finite numbers")
    return Cells(numbers, np.full(len(numbers), None, dtype=object), (), False, int(is_missing.sum()), form, zone)


def _dates(series: "pd.Series[Any]", is_missing: NDArray[np.bool_]) -> Cells:
    if series.dtype.kind == "O":  # a period begins where its date does
        series = series.map(lambda cell: cell.to_timestamp() if isinstance(cell, pd.Period) else cell)
    stamps = series.dt.to_timestamp() if isinstance(series.dtype, pd.PeriodDtype) else series
    try:
        return _numbers(_distinct(read_times(stamps), stamps, "dates"), is_missing, ISO, _zone(stamps))
    except (OverflowError, pd.errors.OutOfBoundsDatetime) as error:
        raise DataError(f"holds a date that pandas cannot hold ({error}); give it as a number of days") from error


def _zone(series: "pd.Series[Any]") -> str:
    """Return the zone of the clock of dates; dates of Arrow have none, and objects of several zones are read as UTC."""
    if series.dtype.kind != "O":
        return zone_of(getattr(getattr(series.dtype, "pyarrow_dtype", series.dtype), "tz", None))
    zones = {zone_of(getattr(cell, "tzinfo", None)) for cell in series[series.notna()]}
    return zones.pop() if len(zones) == 1 else "UTC"


def _durations(series: "pd.Series[Any]", is_missing: NDArray[np.bool_]) -> Cells:
    try:
        spans = pd.to_timedelta(series) if series.dtype.kind == "O" else series
        return _numbers(_distinct(days_in(spans), spans, "durations"), is_missing, DAYS)
    except (OverflowError, pd.errors.OutOfBoundsTimedelta) as error:
        raise DataError(f"holds a duration that pandas cannot hold ({error}); give it as a number of days") from error


def _distinct(days: NDArray[np.float64], series: "pd.Series[Any]", what: str) -> NDArray[np.float64]:
    """Return days; refuse those that float64 merges: of the year 2026 it keeps steps of 0.6 microseconds."""
    if pd.Series(days).nunique() < series.nunique():
        raise DataError(
            f"holds {what} closer to each other than float64 tells days apart; subtract the first one, and give the "
            "rest as numbers"
        )
    return days


def _exact(series: "pd.Series[Any]", is_missing: NDArray[np.bool_]) -> NDArray[np.float64]:
    """Return numbers as float64; refuse a whole number that it cannot hold."""
    numbers = np.asarray(series.to_numpy(dtype=np.float64, na_value=math.nan))
    row = beyond_exact(series.to_numpy(dtype=object) if is_missing.any() else series, numbers)
    if row is not None:
        raise DataError(f"holds {int(series.iloc[row])}, {BEYOND}, or leave it out")
    return numbers


def _categories(series: "pd.Series[Any]", is_missing: NDArray[np.bool_]) -> Cells:
    categories = series.cat.categories
    kind = categories.dtype.kind
    is_date = isinstance(categories.dtype, pd.PeriodDtype) or (
        kind == "O" and len(categories) and all(isinstance(one, DATE_CELLS + DURATION_CELLS) for one in categories)
    )
    if is_date and not series.cat.ordered:
        return read_cells(series.astype(object))
    if kind in "biufmM" and not series.cat.ordered:  # numbers and dates that pandas only stores as categories
        missing = object if kind in "iu" else np.float64  # float64 merges whole numbers
        return read_cells(series.astype(missing if is_missing.any() and kind in "biuf" else categories.dtype))
    values = tuple(str(value) for value in categories)
    codes = series.cat.codes.to_numpy()
    words = np.array([None if code < 0 else values[code] for code in codes], dtype=object)
    present = set(words.tolist())
    kept = tuple(value for value in values if series.cat.ordered or value in present)
    return _texts(words, kept, is_ordered=bool(series.cat.ordered))


def _objects(series: "pd.Series[Any]", is_missing: NDArray[np.bool_], form: str | None) -> Cells:
    cells = series.to_numpy(dtype=object)
    present = cells[~is_missing]
    if len(present) and all(isinstance(cell, DATE_CELLS) for cell in present):
        return _dates(series.astype(object), is_missing)
    if len(present) and all(isinstance(cell, DURATION_CELLS) for cell in present):
        return _durations(series.astype(object), is_missing)
    if len(present) and all(isinstance(cell, time) for cell in present):  # as a file has it
        return _objects(series.astype(object).map(str, na_action="ignore"), is_missing, form)
    odd = next((cell for cell in present if not isinstance(cell, KINDS)), None)
    if odd is not None:
        raise DataError(f"holds {shown(str(odd))} of type {type(odd).__name__}; expected numbers or text")
    said = truths_in(present)
    numbers = _numbers_among(cells, is_missing) if said is None else np.array([said.get(c, math.nan) for c in cells])
    if numbers is not None:
        return _numbers(numbers, np.isnan(numbers))
    read = _written(cells, is_missing, form)
    if read is not None:
        return read
    is_missing = is_missing | np.array([isinstance(cell, str) and cell == UNKNOWN for cell in cells], dtype=bool)
    words = np.array([None if gone else str(cell) for cell, gone in zip(cells, is_missing, strict=True)], dtype=object)
    return _texts(words, tuple(sorted({word for word in words if word is not None})), is_ordered=False)


def _written(cells: NDArray[Any], is_missing: NDArray[np.bool_], form: str | None) -> Cells | None:
    """Return the numbers of texts that have a form; None where they have none."""
    different = {str(cell) for cell in cells[~is_missing]}
    texts = sorted(text for text in different if not is_missing_word(text))
    form = form_of(texts) if form is None else form
    if not form or not texts:
        return None
    number = dict(zip(texts, read_texts(texts, form).tolist(), strict=True))
    read = [math.nan if gone else number.get(str(cell), math.nan) for cell, gone in zip(cells, is_missing, strict=True)]
    numbers = np.array(read)
    return _numbers(numbers, np.isnan(numbers), form, zone_in(texts) if is_date(form) else "")


def _numbers_among(cells: NDArray[Any], is_missing: NDArray[np.bool_]) -> NDArray[np.float64] | None:
    """Return the numbers of cells that all are numbers or words for a missing one; None where some are text."""
    out = np.full(len(cells), math.nan)
    n_numbers = 0
    for row in np.flatnonzero(~is_missing):
        cell = cells[row]
        number = _number_of(cell)
        if number is None or math.isnan(number):
            if not is_missing_word(str(cell)):
                return None
            continue
        out[row] = number
        n_numbers += 1
    return out if n_numbers else None


def _number_of(cell: object) -> float | None:
    if is_beyond(cell):
        raise DataError(f"holds {shown(cell)}, {BEYOND}, or leave it out")
    if isinstance(cell, str):
        return plain_number(cell.strip())
    return float(cell)  # type: ignore[arg-type]


def _texts(words: NDArray[Any], values: tuple[str, ...], *, is_ordered: bool) -> Cells:
    longest = max(values, key=len, default="")
    if len(longest) > MOST_NAME:
        raise DataError(
            f"holds a text of {len(longest)} characters ({shown(longest)}); expected at most {MOST_NAME}; leave it out"
        )
    n_missing = sum(word is None for word in words.tolist())
    return Cells(np.full(len(words), math.nan), words, values, is_ordered, n_missing)
