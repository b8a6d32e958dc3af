"""The costs of wrong labels, from a table."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from octmip.errors import DataError
from octmip.formats.table.samples import read_table
from octmip.input.files import PathLike
from octmip.input.messages import several, shown


def read_costs(path: PathLike, class_names: Sequence[Any]) -> NDArray[np.float64]:
    """Return the cost matrix of a CSV file, rows and columns in the order of `class_names`.

    The header names the predicted classes and the first column the true ones, in any order, as pandas and R write it:

        true,healthy,damaged
        healthy,0,1
        damaged,10,0

    Raises
    ------
    DataError
        a class is missing, unknown or named twice, or a cost is no number.
    """
    table = read_table(path, keeps_names=True)
    first = table.columns[0]
    if first.lower().startswith(("pred", "answer")):
        raise DataError(f"{path} has rows for {shown(first)} classes; expected one for each true class; turn the table")
    rows = [str(value) for value in table.labels(first)]
    wanted = [str(name) for name in class_names]
    for what, got in (("rows", rows), ("columns", list(table.columns[1:]))):
        if sorted(got) != sorted(wanted):
            raise DataError(
                f"{path} has the {what} {several(got)}; expected each of the classes {several(wanted)} once; name them "
                "so"
            )
    return table.numbers(wanted, "cost")[[rows.index(name) for name in wanted]]
