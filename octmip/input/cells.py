"""Cells of CSV text: the rows with the lines that they come from, and what a cell holds as a number."""

import csv
import re
from collections.abc import Iterable, Iterator, Sequence
from decimal import Decimal
from typing import Any

import numpy as np
from numpy.typing import NDArray

EXACT_INTEGERS = 2**53
"""Beyond it float64 merges neighbouring whole numbers."""
MOST_DIGITS = 400
"""A text of more is no number that float64 comes near."""
BEYOND = "beyond 2^53, where float64 merges neighbouring integers; subtract an offset first"
"""What is said of such a number, by every door."""


def beyond_exact(values: Any, numbers: NDArray[np.float64]) -> int | None:
    """Return the position of the first whole number that float64 does not hold; None without one.

    Values of any library became `numbers` of as many dimensions; those that were floats already may be of any size.
    """
    if getattr(getattr(values, "dtype", None), "kind", "O") in "bf":
        return None
    large = np.flatnonzero(np.abs(numbers) >= EXACT_INTEGERS)
    if not len(large):
        return None
    cells = np.asarray(values)
    cells = (cells if cells.dtype.kind in "iu" else np.array(values, dtype=object)).ravel()
    return next((k for k in large.tolist() if is_beyond(cells[k])), None)


def may_be_beyond(numbers: Any) -> bool:
    """Whether a column of float64 holds one that whole numbers may have been merged into."""
    return bool((np.abs(np.asarray(numbers)) >= EXACT_INTEGERS).any())


def is_beyond(cell: object) -> bool:
    """Whether a cell is a whole number, or the text of one, that float64 does not hold."""
    if isinstance(cell, str) and cell.strip().lstrip("+-").isdecimal() and len(cell) < MOST_DIGITS:
        cell = int(cell)
    if isinstance(cell, Decimal) and cell.is_finite() and cell == cell.to_integral_value():
        cell = int(cell)
    if not isinstance(cell, int | np.integer) or abs(int(cell)) <= EXACT_INTEGERS:
        return False
    try:
        return int(float(cell)) != int(cell)
    except OverflowError:
        return True


class CsvRows:
    """Rows of cells between commas, or another separator; a quoted cell may run over several lines.

    Attributes
    ----------
    first, last
        numbers of the first and the last line of the row returned last, or of the one that could not be read.
    """

    def __init__(self, lines: Iterable[tuple[int, str]], strict: bool = False, separator: str = ",") -> None:
        """Take lines with their numbers; `strict` refuses quotation marks that are not closed (`csv.Error`)."""
        self._taken: list[int] = []
        self._reader = csv.reader(self._texts(lines), strict=strict, delimiter=separator)

    def _texts(self, lines: Iterable[tuple[int, str]]) -> Iterator[str]:
        for number, line in lines:
            self._taken.append(number)
            yield line

    def __iter__(self) -> "CsvRows":
        return self

    def __next__(self) -> list[str]:
        self._taken.clear()
        return next(self._reader)

    @property
    def first(self) -> int:
        """Number of the first line."""
        return self._taken[0]

    @property
    def last(self) -> int:
        """Number of the last line."""
        return self._taken[-1]


FORTRAN = re.compile(r"\s*([+-]?(?:\d+\.\d*|\.\d+))(?:[dDqQ]([+-]?\d{1,3})|([+-]\d{3}))\s*")
"""1.5D-03; an exponent of three digits may stand without its letter, as in 1.5-117."""
MISSING_WORDS = frozenset(
    {
        "na",
        "n/a",
        "n.a.",
        "nan",
        "-nan",
        "+nan",
        "<na>",
        "nat",
        "none",
        "null",
        "nil",
        "?",
        ".",
        "missing",
        "*",
        "novalue",
        "no data",
        "k.a.",
        "n.v.",
    }
    | {
        "nan(ind)",
        "-nan(ind)",
        "nan(snan)",
        "1.#qnan",
        "-1.#qnan",
        "1.#ind",
        "-1.#ind",
        "#n/a",
        "#na",
        "#nv",
        "#n/d",
        "\\n",
    }
    | {"-" * k for k in range(9)}
    | {"#div/0!", "#value!", "#ref!", "#name?", "#null!", "#num!", "#spill!", "#calc!", "#wert!", "#bezug!", "#zahl!"}
    | {"#valeur!", "#nom?", "#nombre!", "#nul!", "#¡valor!", "#¿nombre?", "#¡div/0!", "#¡ref!", "#¡num!", "#¡nulo!"}
    | {"#valore!", "#nome?", "#rif!", "#valor!", "#nulo!"}
)
"""What stands among numbers for a missing one: words, dashes, NaN as C libraries print it, a database's NULL, and what
Excel writes of an error in English, German, French, Spanish, Italian and Portuguese."""


def is_missing_word(cell: str) -> bool:
    """Whether a cell among numbers says that there is none."""
    word = cell.strip().lower()
    return word in MISSING_WORDS or (".#" in word and word.rstrip("0") in MISSING_WORDS)


def truths_in(cells: Iterable[object]) -> dict[str, bool] | None:
    """Return which texts say true or false, where no other cell is there but words for a missing one; else None."""
    said: dict[str, bool] = {}
    for cell in set(cells):
        word = cell.strip().lower() if isinstance(cell, str) else ""
        if word in ("true", "false"):
            said[str(cell)] = word == "true"
        elif not is_missing_word(str(cell)):
            return None
    return said or None


def plain_number(cell: str) -> float | None:
    """Return the number in a cell, infinite and NaN among them, or None; digits of other scripts and 1_000 are text."""
    if not cell.isascii() or "_" in cell:  # Python would take both
        return None
    try:
        return float(cell)
    except ValueError:
        found = FORTRAN.fullmatch(cell)
        return None if found is None else float(f"{found[1]}e{found[2] or found[3]}")


def text_by_number(texts: Sequence[str], *, are_truths: bool) -> dict[float | None, str]:
    """Return texts by the number that each says, the first of equal ones; with `are_truths` by 1 for true, 0 for false.

    A part of a table may hold nothing but numbers in a column of texts, or true and false alone, and then a reader
    takes them for what they say.
    """
    if are_truths:
        said = {text.lower(): text for text in reversed(texts)}
        return {float(word == "true"): said.get(word, word) for word in ("false", "true")}
    return {plain_number(text): text for text in reversed(texts)}
