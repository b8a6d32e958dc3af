"""DataFlash of ArduPilot (.bin) by pymavlink: messages of fields, in order of TimeUS.

The unit is the log's own: pymavlink applies the factors of the formats c, C, e, E and L, and writes the log's other
multipliers before the unit ("0.01 m"), without multiplying. Number and unit belong together so, and octmip converts.
"""

import contextlib
import functools
import os
from pathlib import Path
from typing import Any

import numpy as np

from octmip.errors import needed_by
from octmip.recordings.recording import Channel, Recording

os.environ.setdefault("PYMAVLINK_FAST_INDEX", "0")  # the fast index prints past Python on standard output
with needed_by("a recording of DataFlash"):
    from pymavlink.DFReader import DFReader_binary

TIME, MICROSECOND = "TimeUS", 1e-6
ABOUT = frozenset({"FMT", "FMTU", "UNIT", "MULT", "PARM", "MSG", "FILE"})
"""Messages that say what others mean, and those of text."""


def read(path: Path) -> Recording:
    """Return the fields of a log as MESSAGE/FIELD, of an instance as MESSAGE[1]/FIELD."""
    rows: dict[str, list[list[Any]]] = {}
    formats: dict[str, Any] = {}
    with contextlib.closing(DFReader_binary(str(path))) as reader:
        while (message := reader.recv_msg()) is not None:
            kind = message.get_type()
            if kind in ABOUT or TIME not in message.fmt.columns:
                continue
            instance = message.fmt.instance_field
            name = kind if instance is None else f"{kind}[{getattr(message, instance)}]"
            formats[name] = message.fmt
            rows.setdefault(name, []).append([getattr(message, column) for column in message.fmt.columns])
    start = min((own[0][formats[name].columns.index(TIME)] for name, own in rows.items()), default=0)

    def loaded(name: str, field: str) -> Channel:
        form = formats[name]
        place, at = form.columns.index(field), form.columns.index(TIME)
        stamps = np.array([row[at] for row in rows[name]], dtype=np.int64) - start
        unit = form.get_unit(field) or ""
        values = np.array([row[place] for row in rows[name]])
        return Channel(f"{name}/{field}", unit, stamps * MICROSECOND, values)

    loaders = {
        f"{name}/{field}": functools.partial(loaded, name, field)
        for name, form in formats.items()
        for field in form.columns
        if field not in (TIME, form.instance_field)
    }
    return Recording("DataFlash", loaders)
