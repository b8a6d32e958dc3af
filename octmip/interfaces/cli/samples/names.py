"""Names of columns on a command line: lists between commas, in which a name may be quoted as in a CSV file."""

import csv
from collections.abc import Sequence

from octmip.errors import DataError
from octmip.formats.table import Table
from octmip.input.messages import several, shown


def listed_names(table: Table, option: str, values: Sequence[str] | None) -> list[str]:
    """Return the columns that an option names, which may be given several times: ``--drop '"a,b",c' --drop d``.

    Raises
    ------
    DataError
        quotation marks are left open, or the table lacks names or has them given twice; all are named.
    """
    names = [found for value in values or () for found in cells_of(option, value)]
    names = [name if name in table.columns else name.strip() for name in names]
    unknown = [name for name in names if name not in table.columns]
    if unknown:
        raise DataError(
            f"{table.name} has no column {several(unknown, 40)}, which {option} names; expected some of its "
            f"{len(table.columns)} columns: {several(table.columns)}; put a name that holds a comma in double quotes"
        )
    twice = sorted({name for name in names if names.count(name) > 1})
    if twice:
        raise DataError(f"{option} names {several(twice)} twice; name each column once")
    return names


def one_name(table: Table, value: str) -> str:
    """Return the column that an option names: as it stands, or without the quotes that a list would need."""
    if value in table.columns:
        return value
    cells = next(csv.reader([value]), [])
    return cells[0] if len(cells) == 1 and cells[0] in table.columns else value


def cells_of(option: str, value: str) -> list[str]:
    """Return the entries of a list on the command line, between commas, quoted as in a CSV file.

    Raises
    ------
    DataError
        quotation marks are left open, or an entry is empty.
    """
    try:
        cells = next(csv.reader([value], skipinitialspace=True, strict=True), [])
    except csv.Error as error:
        raise DataError(
            f"{option} is {shown(value)}, which cannot be read ({error}); expected names between commas; put a name "
            "that holds a comma in double quotes and write a double quote inside it twice: '\"a,b\",c'"
        ) from error
    if not cells or not all(cell.strip() for cell in cells):
        raise DataError(f"{option} is {shown(value)}; expected names between commas; leave out none")
    return cells
