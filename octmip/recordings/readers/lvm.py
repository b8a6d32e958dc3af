"""LabVIEW's measurement files (.lvm): segments of channels, with one column of times, one before each channel, or none.

Source: National Instruments, Specification for the LabVIEW Measurement File (.lvm).
"""

import functools
import io
import re
from collections.abc import Iterator
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
END_LINE = re.compile(re.escape(END) + ".*\n")
Keys = dict[str, list[str]]
"""Cells behind each word of a header."""


def is_measurement(path: Path) -> bool:
    """Whether a file is a measurement of LabVIEW whose segments have headers of their own."""
    with path.open("rb") as file:
        return file.read(len(BEGIN)) == BEGIN.encode() and file.read(HEAD).count(END.encode()) > 1


def read(path: Path) -> Recording:
    """Return the channels of all segments, each segment from its own date and time on."""
    text, told = Source(path, "tsv").text()
    head, begin, *bodies = END_LINE.split(text.replace("\r\n", "\n"))
    del text  # which is as large as its segments
    separator = "," if "Separator,Comma" in head else "\t"
    found: dict[str, list[tuple[str, Floats, Floats]]] = {}
    start: Any = None
    for body in bodies:  # the rows of a segment, and the header of the next
        keys = _of_channels({**_keys(head, separator), **_keys(begin, separator)})
        rows, _, begin = body.partition("\n\n")
        for k, (name, unit, time, values) in enumerate(_channels(path, rows, keys, separator)):
            stamp = " ".join(keys[key][min(k, len(keys[key]) - 1)] for key in ("Date", "Time") if keys.get(key))
            at = pd.to_datetime(stamp, errors="coerce")
            start = at if start is None else start
            late = 0.0 if pd.isna(at) or pd.isna(start) else (at - start).total_seconds()
            found.setdefault(name, []).append((unit, late + time, values))
    told += (f"{len(bodies)} segments follow one another.",) * (len(bodies) > 1)
    return Recording("lvm", {name: functools.partial(_joined, name, own) for name, own in found.items()}, notes=told)


def _joined(name: str, pieces: list[tuple[str, Floats, Floats]]) -> Channel:
    units, times, values = zip(*pieces, strict=True)
    return Channel(name, units[0], np.concatenate(times), np.concatenate(values))


def _keys(header: str, separator: str) -> Keys:
    cells = ([cell.strip() for cell in line.split(separator)] for line in header.splitlines())
    return {row[0]: row[1:] for row in cells if row[0]}


def _of_channels(keys: Keys) -> Keys:
    """Return a cell for each channel: with times before each, their cells stand over the channels, gaps between."""
    if keys.get("X_Columns", ["One"])[0] != "Multi":
        return keys
    return {key: cells[::2] if len(cells) > 1 and not any(cells[1::2]) else cells for key, cells in keys.items()}


def _channels(path: Path, rows: str, keys: Keys, separator: str) -> Iterator[tuple[str, str, Floats, Floats]]:
    """Yield name, unit, times [s] and numbers of the channels of a segment."""
    stream = io.BytesIO(rows.encode())
    heads = [name.strip() for name in stream.readline().decode().split(separator)]
    heads = heads[:-1] if heads[-1] == "Comment" else heads
    decimal = keys.get("Decimal_Separator", ["."])[0] or "."
    frame = pd.read_csv(
        stream, sep=separator, header=None, names=[*range(len(heads))], usecols=range(len(heads)), decimal=decimal,
        index_col=False, **EXACT_NUMBERS,
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
