"""LabVIEW's measurement files (.lvm): segments of channels, with one column of times, one before each channel, or none.

Source: National Instruments, Specification for the LabVIEW Measurement File (.lvm).
"""

import functools
import io
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from octmip.errors import DataError
from octmip.formats.table.delimited import EXACT_NUMBERS
from octmip.formats.table.source import Source
from octmip.recordings.recording import Channel, Floats, Recording

HEAD = 1 << 16
"""Bytes in which both headers stand."""
BEGIN, END, X = "LabVIEW Measurement", "***End_of_Header***", "X_Value"


def is_measurement(path: Path) -> bool:
    """Whether a file is a measurement of LabVIEW whose segments have headers of their own."""
    with path.open("rb") as file:
        return file.read(len(BEGIN)) == BEGIN.encode() and file.read(HEAD).count(END.encode()) > 1


def read(path: Path) -> Recording:
    """Return the channels of all segments, each segment from its own date and time on."""
    text, told = Source(path, "tsv").text()
    head, begin, *bodies = text.replace("\r\n", "\n").split(END)
    keys = _keys(head.splitlines(), "," if "Separator,Comma" in head else "\t")
    found: dict[str, list[tuple[Floats, Floats]]] = {}
    units: dict[str, str] = {}
    start = None
    for body in bodies:  # the rows of a segment, and the header of the next
        own = {**keys, **_keys(begin.splitlines(), keys["separator"])}
        rows, _, begin = body.partition("\n")[2].partition("\n\n")
        at = pd.to_datetime(" ".join(own[key][0] for key in ("Date", "Time") if key in own), errors="coerce")
        start = at if start is None else start
        late = 0.0 if pd.isna(at) or pd.isna(start) else (at - start).total_seconds()
        for name, unit, time, values in _channels(path, rows, own):
            found.setdefault(name, []).append((late + time, values))
            units.setdefault(name, unit)
    told += (f"{len(bodies)} segments follow one another.",) * (len(bodies) > 1)
    loaders = {name: functools.partial(_joined, name, units[name], own) for name, own in found.items()}
    return Recording("lvm", loaders, notes=told)


def _joined(name: str, unit: str, pieces: list[tuple[Floats, Floats]]) -> Channel:
    time, values = (np.concatenate(part) for part in zip(*pieces, strict=True))
    return Channel(name, unit, time, values)


def _keys(lines: list[str], separator: str) -> dict[str, Any]:
    cells = [[cell.strip() for cell in line.split(separator)] for line in lines]
    return {"separator": separator, **{row[0]: row[1:] for row in cells if row[0]}}


def _channels(path: Path, rows: str, keys: dict[str, Any]) -> Any:
    """Yield name, unit, times [s] and numbers of the channels of a segment."""
    names, _, body = rows.partition("\n")
    heads = [name.strip() for name in names.split(keys["separator"])]
    heads = heads[:-1] if heads[-1] == "Comment" else heads
    decimal = keys.get("Decimal_Separator", ["."])[0] or "."
    frame = pd.read_csv(
        io.StringIO(body), sep=keys["separator"], header=None, names=[*range(len(heads))], usecols=range(len(heads)),
        decimal=decimal, index_col=False, **EXACT_NUMBERS,
    )  # fmt: skip
    kind, times, k = keys.get("X_Columns", ["One"])[0], None, 0
    for column, name in enumerate(heads):
        numbers = frame[column].to_numpy(dtype=np.float64)
        if name == X:
            times = numbers if kind != "No" else None
            continue
        step, zero = (float(keys[key][k].replace(decimal, ".")) if key in keys else np.nan for key in ("Delta_X", "X0"))
        if times is None and not step > 0.0:
            raise DataError(
                f"{path}: channel {name!r} has no times; expected X_Columns One or Delta_X; save it with it"
            )
        time = times if times is not None else np.nan_to_num(zero) + step * np.arange(len(numbers))
        units = keys.get("Y_Unit_Label", [])
        is_there = np.isfinite(time) & (np.isfinite(numbers) | (kind != "Multi"))
        label = f"{name}#{k + 1}" if heads.count(name) > 1 else name
        yield label, units[k] if k < len(units) else "", time[is_there], numbers[is_there]
        k += 1
