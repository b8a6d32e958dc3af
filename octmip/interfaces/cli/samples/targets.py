"""Labels that look like quantities: a tree with a class for each of 40 measured numbers answers no sensible question.

Texts, booleans and few numbers are classes. Numbers are questioned when more than 10 are different and one of these
holds: some are not whole; more than 30 are different; there are fewer than 5 rows for each different number.
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from octmip.errors import DataError
from octmip.formats.table import Table
from octmip.input.messages import shown

FEW, MANY, ROWS_EACH = 10, 30, 5


def refuse_quantity(table: Table, column: str, labels: NDArray[Any]) -> None:
    """Refuse a label whose numbers look like a quantity instead of classes; the rule is that of the module.

    Raises
    ------
    DataError
        it does.
    """
    if labels.dtype.kind not in "iuf":
        return
    numbers = np.unique(labels)
    is_whole = bool((numbers == np.floor(numbers)).all())
    if len(numbers) <= FEW or (is_whole and len(numbers) <= MANY and len(labels) >= ROWS_EACH * len(numbers)):
        return
    raise DataError(
        f"{table.name}, column {shown(column)}: the label has {len(numbers)} different numbers in {len(labels)} rows "
        f"(from {numbers[0]:g} to {numbers[-1]:g}): is it a quantity to be estimated (a regression target)? Expected "
        f"classes; predict the number by --target {shown(column)} instead of --label, sort the numbers into a few "
        "ranges first, or add --numbers-are-classes if each number is a class"
    )
