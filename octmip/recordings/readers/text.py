"""Tables whose rows are samples: TOA5, .lvm, CSV, Parquet, read as `octmip.formats.table` reads every table."""

import functools
from pathlib import Path
from types import MappingProxyType

from octmip.errors import DataError
from octmip.formats.table import read_table
from octmip.formats.table.units import unit_behind
from octmip.gap.campaign.columns import TIME, CampaignColumns
from octmip.input.messages import several
from octmip.recordings.readers import lvm
from octmip.recordings.readers.clock import TIMES, times_among
from octmip.recordings.recording import Channel, Recording


def read(path: Path) -> Recording:
    """Return the columns of a table beside its times.

    Raises
    ------
    DataError
        no column holds times, or they cannot be read.
    """
    if lvm.is_measurement(path):
        return lvm.read(path)
    table = read_table(path, keeps_names=True)
    units = {column: unit_behind(column)[1] or dict(table.units).get(column, "") for column in table.columns}
    stamps = times_among(units)
    if stamps is None and "" in table.columns and table.frame[""].dtype.kind not in "iuf":
        stamps = ""  # an index; one of numbers may count samples
    if stamps is None:
        raise DataError(
            f"{path}: no column holds times; expected one called {several(TIMES)} among {several(table.columns, 12)}; "
            "rename it"
        )
    given = {TIME if column == stamps else column: unit for column, unit in units.items()}
    place = MappingProxyType({TIME if column == stamps else column: column for column in table.columns})
    columns = CampaignColumns(table, place, given, ())
    time, how = columns.time()

    def loaded(column: str) -> Channel:
        return Channel(column, units[column], time, columns.floats(column, words=True, infinite=True))

    others = [column for column in table.columns if column and column != stamps]
    return Recording("table", {name: functools.partial(loaded, name) for name in others}, notes=(*table.notes, *how))
