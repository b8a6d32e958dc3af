"""Readings as other libraries hold them, as numbers in the order of their names: NaN where one is missing.

Columns with names are matched by name, in whatever order they stand: those of data frames (pandas, polars), Arrow
tables, mappings, named tuples, xarray datasets, structured arrays, and of a series with one value for each name.
Arrays and lists have no names, and are taken in the order of the names. A mask, None and NA are missing values.
"""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from octmip.errors import DataError

Floats = NDArray[np.float64]


def by_name(given: Any, names: Sequence[str], what: str) -> tuple[Floats, tuple[str, ...]]:
    """Return rows (n, n_names) in the order of the names, and the names of columns that were not asked for.

    Parameters
    ----------
    given
        rows of numbers; one row may be given as (n_names,).
    names
        of the columns.
    what
        what they are, as a sentence begins: "test 'pull'".

    Raises
    ------
    DataError
        a name is lacking, another number of columns, or a value that is no number.
    """
    _refuse_quantity(given, what)
    columns = columns_of(given)
    if columns is None:
        rows = np.atleast_2d(numbers_in(given, what))
        if rows.ndim != 2 or rows.shape[1] != len(names):
            raise DataError(
                f"{what}: shape {np.shape(given)}; expected {len(names)} columns, one for each of the readings "
                f"{', '.join(names[:3])}..."
            )
        return rows, ()
    lacking = [name for name in names if name not in columns]
    extra = tuple(name for name in columns if name not in names)
    if lacking:
        other = f", but the unknown {extra[0]!r}" if extra else ""
        raise DataError(
            f"{what}: there is no column {lacking[0]!r} ({len(lacking)} of {len(names)} readings are lacking){other}; "
            "expected the names of all readings; rename the columns, or add one that is empty (NaN) for a reading that "
            "was not taken"
        )
    found = [np.atleast_1d(numbers_in(columns[name], f"{what}, column {name!r}")) for name in names]
    lengths = {column.shape for column in found}
    if len(lengths) > 1 or len(next(iter(lengths))) != 1:
        raise DataError(f"{what}: columns of shapes {sorted(lengths)}; expected one number for each repeat in all")
    return np.column_stack(found), extra


def columns_of(given: Any) -> dict[str, Any] | None:
    """Return the columns by name; None where they have none, or are only numbered.

    Raises
    ------
    DataError
        a name stands twice, or the rows are not there yet.
    """
    if hasattr(given, "collect") and hasattr(given, "lazy"):
        raise DataError(f"a {type(given).__name__} is a query without rows yet; expected a table; collect() it first")
    if hasattr(given, "_asdict"):  # a tuple with names
        given = given._asdict()
    if isinstance(given, Mapping):
        names: Sequence[Any] = list(given)
    elif getattr(getattr(given, "dtype", None), "names", None):
        names = list(given.dtype.names)
    elif hasattr(given, "column_names"):  # an Arrow table, whose `columns` are the data
        names = list(given.column_names)
    elif hasattr(given, "columns"):
        names = list(given.columns)
    elif getattr(given, "ndim", 0) == 1 and hasattr(given, "index") and not callable(given.index):
        names = list(given.index)
        given = dict(zip(names, given, strict=True))
    else:
        return None
    if all(isinstance(name, int | np.integer) for name in names):
        return None
    twice = sorted({str(name) for name in names if names.count(name) > 1})
    if twice:
        raise DataError(f"column {twice[0]!r} stands {names.count(twice[0])} times; expected once; drop all but one")
    return {str(name): given[name] for name in names}


def as_mapping(given: Any) -> Any:
    """Return the values of a series that names them as a mapping; others as they are."""
    is_named = not isinstance(given, Mapping) and hasattr(given, "index") and columns_of(given) is not None
    return columns_of(given) if is_named else given


def _refuse_quantity(given: Any, what: str) -> None:
    """Refuse numbers that carry a unit, which an array would lose."""
    for value in "magnitude", "to_value":
        if hasattr(given, value):
            unit = getattr(given, "units", getattr(given, "unit", ""))
            raise DataError(
                f"{what}: numbers in {unit}; expected plain numbers in the twin's units; convert them, and give "
                f"their {'magnitude' if value == 'magnitude' else 'value'}"
            )


def unmasked(values: Any) -> Any:
    """Return what may be a masked array as a plain one, NaN where a number is masked and None where a text is."""
    if not isinstance(values, np.ma.MaskedArray) or not np.ma.is_masked(values):
        return values
    is_number = values.dtype.kind in "bf" or (values.dtype.kind in "iu" and values.dtype.itemsize < 8)
    plain = values.data.astype(np.float64 if is_number else object)
    plain[np.ma.getmaskarray(values)] = np.nan if is_number else None
    return plain


def settled(given: Any) -> Any:
    """Return a column of another library as an array, of objects where some are missing: whole numbers stay whole."""
    if not hasattr(given, "to_numpy") or isinstance(given, np.ndarray):
        return given
    if getattr(given, "null_count", 0):
        return np.array(given.to_pylist() if hasattr(given, "to_pylist") else given.to_list(), dtype=object)
    if hasattr(given, "isna") and given.isna().to_numpy().any():  # pandas, some of whose types become float64
        return given.to_numpy(dtype=None if isinstance(given.dtype, np.dtype) else object)
    return given.to_numpy()


def numbers_in(given: Any, what: str) -> Floats:
    """Return numbers of any shape, NaN where masked, None or NA.

    Raises
    ------
    DataError
        some are none.
    """
    _refuse_quantity(given, what)
    given = settled(given)
    try:
        array = np.ma.array(given) if isinstance(given, list | tuple | np.ma.MaskedArray) else np.asarray(given)
    except (TypeError, ValueError) as error:  # such as a list of numbers with units
        raise DataError(f"{what}: values that are no numbers ({error}); expected numbers, NaN if missing") from error
    mask = np.ma.getmaskarray(array) if isinstance(array, np.ma.MaskedArray) else np.zeros(array.shape, dtype=bool)
    plain = np.ma.getdata(array)
    if plain.dtype.kind in "cmM":
        raise DataError(f"{what}: values of type {plain.dtype}; expected numbers; convert them to real ones first")
    if plain.dtype.kind == "O":
        plain = np.array([np.nan if _is_missing(value) else value for value in plain.ravel()], dtype=object)
    try:
        found = plain.astype(np.float64).reshape(array.shape)
    except (TypeError, ValueError, OverflowError) as error:
        odd = next(filter(_is_odd_text, plain.ravel().tolist()), None)
        why = error if odd is None else f"such as {odd[:60]!r}"
        raise DataError(f"{what}: values that are no numbers ({why}); expected numbers, NaN if missing") from error
    found[mask] = np.nan
    return found


def _is_odd_text(value: Any) -> bool:
    try:
        float(value)
    except (TypeError, ValueError, OverflowError):
        return isinstance(value, str)
    return False


def _is_missing(value: object) -> bool:
    return value is None or value is np.ma.masked or type(value).__name__ in ("NAType", "NaTType")
