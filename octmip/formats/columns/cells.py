"""The cells of one column of a table: numbers, or texts, and which of them are missing.

Numbers that a file keeps as text ("5.5", "?") are numbers again, with words such as "?" among them missing.
"""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from octmip.errors import DataError
from octmip.formats.cells import plain_number
from octmip.formats.messages import MOST_NAME, shown

MISSING_WORDS = frozenset({"", "na", "n/a", "nan", "none", "null", "nil", "?", "-", "missing"})
UNKNOWN = "?"
"""Missing among texts too, as no value is called so; "NA" or "none" may be one."""
EXACT_INTEGERS = 2**53  # beyond it float64 merges neighbouring integers


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
    """

    numbers: NDArray[np.float64]
    words: NDArray[Any]
    values: tuple[str, ...]
    is_ordered: bool
    n_missing: int

    @property
    def is_text(self) -> bool:
        """Whether the column holds texts."""
        return len(self.values) > 0


def read_cells(series: "pd.Series[Any]") -> Cells:
    """Return the cells of a column.

    Raises
    ------
    DataError
        a cell is neither a number, true or false, nor a text, or no float64 holds it; the sentence begins behind
        the name of the column.
    """
    is_missing = series.isna().to_numpy(dtype=bool)
    if isinstance(series.dtype, pd.CategoricalDtype):
        return _categories(series, is_missing)
    if series.dtype.kind in "mM":
        raise DataError("holds dates or durations; turn it into a number, such as days since the first")
    if series.dtype.kind == "c":
        raise DataError("holds complex numbers; give real and imaginary parts as two columns")
    if series.dtype.kind in "biuf":
        return _numbers(_exact(series, is_missing), is_missing)
    return _objects(series, is_missing)


def _numbers(numbers: NDArray[np.float64], is_missing: NDArray[np.bool_]) -> Cells:
    infinite = np.flatnonzero(np.isinf(numbers))
    if len(infinite):
        raise DataError(f"is {numbers[infinite[0]]:g} in row {infinite[0] + 1}; expected finite numbers")
    return Cells(numbers, np.full(len(numbers), None, dtype=object), (), False, int(is_missing.sum()))


def _exact(series: "pd.Series[Any]", is_missing: NDArray[np.bool_]) -> NDArray[np.float64]:
    """Return numbers as float64; refuse a whole number that it cannot hold."""
    if series.dtype.kind in "iu":
        present = series[~is_missing]
        beyond = np.flatnonzero(((present > EXACT_INTEGERS) | (present < -EXACT_INTEGERS)).to_numpy(dtype=bool))
        if len(beyond):
            raise DataError(
                f"holds {int(present.iloc[int(beyond[0])])}, beyond 2^53, where float64 merges neighbouring integers; "
                "subtract an offset first, or leave it out"
            )
    return np.asarray(series.to_numpy(dtype=np.float64, na_value=math.nan))


def _categories(series: "pd.Series[Any]", is_missing: NDArray[np.bool_]) -> Cells:
    categories = series.cat.categories
    if categories.dtype.kind in "biuf" and not series.cat.ordered:  # numbers that pandas only stores as categories
        return read_cells(series.astype(categories.dtype if not is_missing.any() else np.float64))
    values = tuple(str(value) for value in categories)
    codes = series.cat.codes.to_numpy()
    words = np.array([None if code < 0 else values[code] for code in codes], dtype=object)
    present = set(words.tolist())
    kept = tuple(value for value in values if series.cat.ordered or value in present)
    return _texts(words, kept, is_ordered=bool(series.cat.ordered))


def _objects(series: "pd.Series[Any]", is_missing: NDArray[np.bool_]) -> Cells:
    cells = series.to_numpy(dtype=object)
    present = cells[~is_missing]
    odd = next((cell for cell in present if not isinstance(cell, str | int | float | np.number | np.bool_)), None)
    if odd is not None:
        raise DataError(f"holds {shown(str(odd))} of type {type(odd).__name__}; expected numbers or text")
    numbers = _numbers_among(cells, is_missing)
    if numbers is not None:
        return _numbers(numbers, np.isnan(numbers))
    is_missing = is_missing | (cells == UNKNOWN)
    words = np.array([None if gone else str(cell) for cell, gone in zip(cells, is_missing, strict=True)], dtype=object)
    return _texts(words, tuple(sorted({word for word in words if word is not None})), is_ordered=False)


def _numbers_among(cells: NDArray[Any], is_missing: NDArray[np.bool_]) -> NDArray[np.float64] | None:
    """Return the numbers of cells that all are numbers or words for a missing one; None where some are text."""
    out = np.full(len(cells), math.nan)
    n_numbers = 0
    for row in np.flatnonzero(~is_missing):
        cell = cells[row]
        number = _number_of(cell)
        if number is None or math.isnan(number):
            if str(cell).strip().lower() not in MISSING_WORDS:
                return None
            continue
        out[row] = number
        n_numbers += 1
    return out if n_numbers else None


def _number_of(cell: object) -> float | None:
    if isinstance(cell, str):
        return plain_number(cell.strip())
    if isinstance(cell, int | np.integer) and abs(int(cell)) > EXACT_INTEGERS:
        raise DataError(
            f"holds {shown(int(cell))}, beyond 2^53, where float64 merges neighbouring integers; subtract an offset "
            "first, or leave it out"
        )
    return float(cell)  # type: ignore[arg-type]


def _texts(words: NDArray[Any], values: tuple[str, ...], *, is_ordered: bool) -> Cells:
    longest = max(values, key=len, default="")
    if len(longest) > MOST_NAME:
        raise DataError(
            f"holds a text of {len(longest)} characters ({shown(longest)}); expected at most {MOST_NAME}; leave it out"
        )
    n_missing = sum(word is None for word in words.tolist())
    return Cells(np.full(len(words), math.nan), words, values, is_ordered, n_missing)
