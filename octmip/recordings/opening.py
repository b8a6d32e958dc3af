"""One table of formats: what a file begins with, and the reader of it. A new format is one file and one line here."""

import importlib
import re
from dataclasses import replace
from pathlib import Path

from octmip.errors import DataError
from octmip.input.files import PathLike, read_head
from octmip.recordings.foreign_reader import foreign
from octmip.recordings.recording import Recording

HEAD = 200
"""Bytes that tell a format."""
FORMATS = {
    "TDMS": (rb"TDSm", "tdms"),
    "MDF": (rb"MDF  |UnFinMF ", "mdf"),
    "ULog": (rb"ULog\x01\x12\x35", "ulog"),
    "DataFlash": (rb"\xa3\x95\x80", "dataflash"),
    "MCAP": (rb"\x89MCAP0\r\n", "mcap"),
    "rosbag": (rb"#ROSBAG V2|SQLite format 3", "rosbag"),
    "miniSEED": (rb"\d{6}[DRQMV][ \x00].{12}|MS\x03", "miniseed"),
    "UFF58": (rb"\s{0,80}-1\s*\n\s*\d{2,4}b?\s", "uff"),
    "MAT": (rb"MATLAB [57]\.", "mat"),
}
"""What its files begin with, and the file of `octmip.recordings.readers` whose ``read(path)`` returns the Recording."""


def format_of(path: PathLike) -> str:
    """Return the format of a file by what it begins with, "" where it is none of `FORMATS`.

    Raises
    ------
    DataError
        it cannot be read.
    """
    head = read_head(path, HEAD)
    return next((name for name, (begins, _) in FORMATS.items() if re.match(begins, head, re.DOTALL)), "")


def recording(path: PathLike) -> Recording:
    r"""Return the recording in a file; channels are read when they are asked for.

    What is none of `FORMATS` is a table as `octmip.formats.table` reads it: TOA5, .lvm, CSV, Parquet.

    Raises
    ------
    DataError
        it cannot be read, or holds no channel.
    MissingExtraError
        the library of its format is not installed.

    Examples
    --------
    >>> from pathlib import Path
    >>> _ = Path("run.csv").write_text("time,g1\n0,1.5\n1,2.5\n")
    >>> run = recording("run.csv")
    >>> run.channels, run["g1"].values.tolist()
    (('g1',), [1.5, 2.5])
    """
    name = format_of(path)
    module = FORMATS[name][1] if name else "text"
    with foreign(str(path), name or "a table") as said:
        reader = importlib.import_module(f"octmip.recordings.readers.{module}")
        found: Recording = reader.read(Path(path))
    if not found.loaders:
        raise DataError(f"{path} ({found.format}) holds no channel of numbers with times; expected at least one")
    return replace(found, name=str(path), notes=(*found.notes, *said))
