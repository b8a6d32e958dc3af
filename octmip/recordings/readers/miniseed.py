"""miniSEED by obspy: one channel an identifier, in pieces between its gaps. The format has no units.

`Stream.merge` is not used, but `read` already moves a piece that begins within half a sample of the grid of the one
before onto that grid; a note says so.
"""

import functools
from pathlib import Path

import numpy as np

from octmip.errors import needed_by
from octmip.recordings.recording import Channel, Recording

with needed_by("a recording of miniSEED"):
    import obspy


def read(path: Path) -> Recording:
    """Return the channels of a file by their identifiers, such as XX.BEAM..HHZ."""
    pieces: dict[str, list[obspy.Trace]] = {}
    for trace in obspy.read(str(path), format="MSEED"):
        pieces.setdefault(trace.id, []).append(trace)
    start = min((one.stats.starttime.ns for own in pieces.values() for one in own), default=0)

    def loaded(name: str) -> Channel:
        own = sorted(pieces[name], key=lambda trace: trace.stats.starttime.ns)
        time = [(one.stats.starttime.ns - start) / 1e9 + one.stats.delta * np.arange(one.stats.npts) for one in own]
        return Channel(name, "", np.concatenate(time), np.concatenate([one.data for one in own]))

    notes = (
        "miniSEED holds no unit and no calibration: numbers are taken in the twin's units.",
        "obspy joins pieces that begin within half a sample of where the one before goes on: times may be so far off.",
    )
    return Recording("miniSEED", {name: functools.partial(loaded, name) for name in pieces}, start, notes)
