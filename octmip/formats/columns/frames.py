"""Tables and series of other libraries, and masked arrays, as pandas holds them: no value changes on the way.

polars, pyarrow, DuckDB and DataFusion give their tables as a stream of Arrow (the PyCapsule interface), which pyarrow
reads. Its types are kept: whole numbers with missing cells stay whole, where numpy makes floats of them.
"""

from typing import TYPE_CHECKING, Any

import pandas as pd

from octmip.errors import DataError, needed_by
from octmip.input.messages import shown
from octmip.input.named_arrays import unmasked

if TYPE_CHECKING:
    import pyarrow

STREAM = "__arrow_c_stream__"


def frame_of(table: Any) -> Any:
    """Return a table as a pandas frame; an array or list as it is, but NaN or None where it is masked.

    Raises
    ------
    DataError
        two columns have one name, or the rows of a query are not there yet.
    MissingExtraError
        pyarrow is needed and not installed.
    """
    if hasattr(table, STREAM) and not isinstance(table, pd.DataFrame | pd.Series):
        with needed_by(f"a {type(table).__name__} as samples"):
            import pyarrow
        try:
            table = _of_arrow(pyarrow.table(table))
        except pyarrow.ArrowInvalid as error:  # such as 128-bit integers of polars
            raise DataError(
                f"X is a {type(table).__name__} that Arrow cannot take ({error}); cast its column"
            ) from error
    if getattr(getattr(table, "dtype", None), "names", None):  # a structured array
        table = pd.DataFrame({name: unmasked(table[name]) for name in table.dtype.names})
    if hasattr(table, "collect") and hasattr(table, "lazy"):
        raise DataError(
            f"X is a {type(table).__name__}, a query without rows yet; expected a table; collect() it first"
        )
    if isinstance(table, pd.DataFrame) and not table.columns.is_unique:
        name = table.columns[table.columns.duplicated()][0]
        raise DataError(f"X has two columns called {shown(str(name))}; expected a name of its own for each; rename one")
    return unmasked(table)


def series_of(values: Any) -> Any:
    """Return the series of another library as one of pandas; an array or list as it is, but NaN where it is masked."""
    if hasattr(values, STREAM) and not isinstance(values, pd.DataFrame | pd.Series):
        with needed_by(f"a {type(values).__name__} as labels"):
            import pyarrow
        if hasattr(values, "columns"):
            return frame_of(values)
        labels = pyarrow.chunked_array(values)
        if pyarrow.types.is_string_view(labels.type):  # pandas does not know these texts, which polars gives
            labels = labels.cast("large_string")
        return pd.Series(pd.arrays.ArrowExtensionArray(labels), name=getattr(values, "name", None))
    return unmasked(values)


def _of_arrow(table: "pyarrow.Table") -> pd.DataFrame:
    columns = {k: _series(column) for k, column in enumerate(table.columns)}
    return pd.DataFrame(columns, index=range(table.num_rows)).set_axis(table.column_names, axis=1)


def _series(column: "pyarrow.ChunkedArray") -> "pd.Series[Any]":
    """Return a column of Arrow in its own type where pandas knows that, else as objects, whose types are then named."""
    from pyarrow import types

    kind = column.type
    if types.is_string_view(kind):  # texts as polars has them
        column, kind = column.cast("large_string"), None
    known = (types.is_primitive, types.is_decimal, types.is_dictionary, types.is_string, types.is_large_string)
    if kind is None or (any(knows(kind) for knows in known) and not types.is_interval(kind)):
        return pd.Series(pd.arrays.ArrowExtensionArray(column))
    cells = column.to_pylist()
    return pd.Series([_span(cell) for cell in cells] if types.is_interval(kind) else cells, dtype=object)


def _span(cell: Any) -> Any:
    """Return an interval as DuckDB has it as a duration; one of months has no length, and stays what it is."""
    if cell is None or cell.months:
        return cell
    return pd.Timedelta(days=cell.days) + pd.Timedelta(cell.nanoseconds, unit="ns")
