"""TDMS by npTDMS: groups of channels, each a waveform, or beside a channel of times in its group.

npTDMS stamps and scales every sample from the properties that stand last in the file. A file that was stopped and gone
on with has several starts: each segment is stamped here by its own. Where segments are scaled by different numbers,
no sample before the last change is right, so the channel is refused.
"""

import functools
from collections import Counter
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from octmip.errors import DataError, needed_by
from octmip.formats.table.units import unit_behind
from octmip.input.messages import several
from octmip.recordings.readers.clock import doubts, seconds_in, times_among
from octmip.recordings.recording import Channel, Floats, Recording, seconds_since

with needed_by("a recording of TDMS"):
    from nptdms import TdmsFile
    from nptdms.reader import TdmsReader, _number_of_segment_values

Pieces = list[tuple[int, dict[str, Any]]]
"""Samples of a channel in each segment, and its properties there."""


class _Segments(TdmsReader):  # type: ignore[misc]
    """The properties of each segment, which `TdmsFile` keeps of the last one alone."""

    def __init__(self, path: Path) -> None:
        super().__init__(path)
        self.given: list[dict[str, Any]] = []
        try:
            self.read_metadata(require_segment_indexes=True)
        finally:
            self.close()

    def _update_object_properties(self, properties: Any) -> None:
        super()._update_object_properties(properties)
        self.given.append(properties or {})

    def pieces(self, path: str) -> Pieces:
        found, now = [], dict[str, Any]()
        for segment, given in zip(self._segments, self.given, strict=True):
            now = now | dict(given.get(path, ()))
            place = segment.object_index.get(path)
            n = 0 if place is None else int(_number_of_segment_values(segment.ordered_objects[place], segment))
            found += [(n, now)] if n else []
        return found


def read(path: Path) -> Recording:
    """Return the channels of a TDMS file."""
    segments, starts, counted = _Segments(path), list[int](), list[Floats]()
    with TdmsFile.open(path, raw_timestamps=True) as file:
        pieces = {
            (one.group_name, one.name): segments.pieces(one.path) for group in file.groups() for one in group.channels()
        }
        for (group, name), own in pieces.items():
            starts += [at for _, given in own if (at := _nanoseconds(given.get("wf_start_time"))) is not None]
            unit = str(own[-1][1].get("unit_string", "")) if own else ""
            if own and times_among({name: unit}):
                ends = [file[group][name][k] for k in (0, -1)]
                if (first := _nanoseconds(ends[0])) is not None:
                    starts.append(first)
                elif not (isinstance(ends[0], str) or unit or unit_behind(name)[1]):
                    counted.append(np.asarray(ends, dtype=np.float64))
        cut = "The last segment is shorter than it says: was the file cut?"
        notes = ((cut,) * file.file_status.incomplete_final_segment, doubts(counted), _without_start(pieces, starts))
    start = min(starts, default=None)

    def loaded(group: str, name: str) -> Channel:
        own = pieces[group, name]
        scales = [[pair for pair in given.items() if pair[0].startswith(("NI_Scal", "unit_"))] for _, given in own]
        if any(scale != scales[0] for scale in scales):
            raise DataError(
                f"channel {name!r} is scaled anew within the file, and npTDMS scales all of it by the last numbers; "
                "expected one scale; split the file where it was calibrated"
            )
        with TdmsFile.open(path, raw_timestamps=True) as file:
            time = _waveform(own, start or 0)
            time = _beside(file[group], name, start or 0) if time is None else time
            return Channel(f"{group}/{name}", str(own[-1][1].get("unit_string", "")), time, file[group][name][:])

    names = Counter("/".join(key) for key in pieces if pieces[key])
    # channel C of group A/B and B/C of A would both be A/B/C
    label = {key: name if names[name := "/".join(key)] == 1 else "'{}'/'{}'".format(*key) for key in pieces}
    loaders = {label[key]: functools.partial(loaded, *key) for key in pieces if pieces[key]}
    return Recording("TDMS", loaders, start, sum(notes, ()))


def _without_start(pieces: Mapping[tuple[str, str], Pieces], starts: Sequence[int]) -> tuple[str, ...]:
    """Return a sentence on waveforms without a start in a file where others have one."""
    firsts = {"/".join(key): own[0][1] for key, own in pieces.items() if own}
    bare = [name for name, given in firsts.items() if "wf_increment" in given and "wf_start_time" not in given]
    told = f"Channels without a start are taken to begin with the first of the others: {several(bare, 6)}."
    return (told,) if bare and starts else ()


def _nanoseconds(stamp: Any) -> int | None:
    return int(stamp.as_datetime64("ns").astype(np.int64)) if hasattr(stamp, "as_datetime64") else None


def _waveform(pieces: Pieces, zero: int) -> Floats | None:
    """Return the times of a waveform; a segment that repeats the start of the one before goes on from there."""
    found, last, n_before = [], None, 0
    for n, given in pieces:
        if not given.get("wf_increment"):
            return None
        at = (_nanoseconds(given.get("wf_start_time")), given.get("wf_start_offset", 0.0))
        n_before = n_before if at == last else 0
        begin = ((at[0] or zero) - zero) / 1e9 + at[1]
        found.append(begin + given["wf_increment"] * np.arange(n_before, n_before + n))
        last, n_before = at, n_before + n
    return np.concatenate(found)


def _beside(group: Any, name: str, zero: int) -> Floats:
    """Return the times that another channel of the group has."""
    units = {one.name: str(one.properties.get("unit_string", "")) for one in group.channels() if one.name != name}
    clock = times_among(units)
    if clock is None:
        raise DataError(f"channel {name!r} has no times: no wf_increment and no channel 'time' beside it; add one")
    times = group[clock][:]
    if hasattr(times, "as_datetime64"):
        return seconds_since(zero, times.as_datetime64("ns").astype(np.int64))
    return seconds_in(clock, units[clock], times)
