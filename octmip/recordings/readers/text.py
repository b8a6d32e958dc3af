"""Tables whose rows are samples: TOA5, .lvm, CSV, Parquet, read as `octmip.formats.table` reads every table."""

import functools
from pathlib import Path
from types import MappingProxyType

from octmip.errors import DataError
from octmip.formats.table import read_table
from octmip.formats.table.units import unit_behind
from octmip.gap.campaign.columns import OWN, TIME, CampaignColumns
from octmip.input.messages import several
from octmip.recordings.recording import Channel, Recording

TIMES = (*OWN[TIME], "x_value", "t")
"""How files call the column of times, in any case."""


def _is_time(name: str) -> bool:
    return (name.lower() if len(name) > 1 else name) in TIMES  # T is a temperature


def read(path: Path) -> Recording:
    """Return the columns of a table beside its times.

    Raises
    ------
    DataError
        no column holds times, or they cannot be read.
    """
    table = read_table(path, keeps_names=True)
    named = {column: unit_behind(column) for column in table.columns}
    stamps = next((column for column, (name, _) in named.items() if _is_time(name.strip())), None)
    if stamps is None and "" in named and table.frame[""].dtype.kind not in "iuf":  # an index, which may count samples
        stamps = ""
    if stamps is None:
        raise DataError(
            f"{path}: no column holds times; expected one called {several(TIMES)} among {several(table.columns, 12)}; "
            "rename it"
        )
    units = {column: unit or dict(table.units).get(column, "") for column, (_, unit) in named.items()}
    given = {TIME if column == stamps else column: unit for column, unit in units.items()}
    place = MappingProxyType({TIME if column == stamps else column: column for column in table.columns})
    columns = CampaignColumns(table, place, given, ())
    time, how = columns.time()

    def loaded(column: str) -> Channel:
        return Channel(column, units[column], time, columns.floats(column, words=True))

    others = [column for column in table.columns if column and column != stamps]
    return Recording("table", {name: functools.partial(loaded, name) for name in others}, notes=(*table.notes, *how))
