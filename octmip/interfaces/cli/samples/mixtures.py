"""Columns of numbers in which a few cells are words: a slip of the pen more often than a column of text.

A column is questioned when it holds more than 20 different numbers and words in at most a tenth of its cells, words for
"missing" aside. Columns such as "2, 3, 4, 5more" are text and pass.
"""

from collections.abc import Sequence

import numpy as np

from octmip.errors import DataError
from octmip.formats.columns.written import form_of
from octmip.formats.table import Table
from octmip.input.cells import is_missing_word, plain_number
from octmip.input.messages import shown

MANY_NUMBERS, FEW_WORDS = 20, 0.1


def mixed_columns(table: Table, names: Sequence[str]) -> dict[str, str]:
    """Return what is wrong with each column of numbers that holds a few words, by name."""
    found = {}
    for name in names:
        column = table.frame[name]
        rows = np.flatnonzero(column.notna().to_numpy())
        cells = column.iloc[rows].tolist()
        if column.dtype.kind in "biufmM" or not all(isinstance(cell, str) for cell in cells):
            continue
        numbers = {cell for cell in set(cells) if plain_number(cell.strip().replace(",", ".")) is not None}
        words = {cell for cell in set(cells) - numbers if not is_missing_word(cell)}
        if words and _has_form(words):
            continue
        at = [row for row, cell in zip(rows.tolist(), cells, strict=True) if cell in words]
        if 0 < len(at) <= FEW_WORDS * len(cells) and len(numbers) > MANY_NUMBERS:
            found[name] = (
                f"holds the word {shown(column.iloc[at[0]])} among numbers ({table.place(at[0], name)}; {len(at)} such "
                "cells); correct it, or add --categories yes-no if all of its cells are words"
            )
    return found


def _has_form(words: set[str]) -> bool:
    """Whether words are numbers as people write them, such as 1,000.50 among numbers below 1,000."""
    try:
        return form_of(sorted(words)) is not None
    except DataError:  # what is wrong with them is said where they are read
        return True
