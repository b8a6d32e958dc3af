"""TDMS by npTDMS: groups of channels, each a waveform, or beside a channel of times in its group.

npTDMS stamps and scales every sample from the properties that stand last in the file. A file that was stopped and gone
on with has several starts: each segment is stamped here by its own. Where segments are scaled by different numbers,
no sample before the last change is right, so the channel is refused.
"""

import contextlib
import functools
import itertools
import operator
from pathlib import Path
from typing import Any

import numpy as np

from octmip.errors import DataError, needed_by
from octmip.formats.table.units import unit_behind
from octmip.input.messages import several
from octmip.recordings.readers.clock import doubts, seconds_in, times_among
from octmip.recordings.recording import Channel, Floats, Recording, seconds_since, told_apart

with needed_by("a recording of TDMS"):
    from nptdms import TdmsFile
    from nptdms.reader import TdmsReader

Pieces = list[tuple[int, dict[str, Any]]]
"""Samples of a channel in each segment, and its properties there."""
START, STEP, OFFSET, UNIT = "wf_start_time", "wf_increment", "wf_start_offset", "unit_string"
CUT = "The last segment is shorter than it says: was the file cut?"


class _Segments(TdmsReader):  # type: ignore[misc]
    """The properties of each segment, which `TdmsFile` keeps of the last one alone."""

    def __init__(self, path: Path) -> None:
        super().__init__(path)
        self.given: list[dict[str, Any]] = []
        with contextlib.closing(self):
            self.read_metadata(require_segment_indexes=True)

    def _update_object_properties(self, properties: Any) -> None:
        super()._update_object_properties(properties)
        self.given.append(properties or {})

    def pieces(self, path: str) -> Pieces:
        self._build_index(path)
        first, ends = self._segment_channel_offsets[path]
        own = (dict(given.get(path, ())) for given in self.given)
        known = itertools.islice(itertools.accumulate(own, operator.or_), first, None)
        return [(n, now) for n, now in zip(np.diff(ends, prepend=0).tolist(), known, strict=False) if n]


def read(path: Path) -> Recording:
    """Return the channels of a TDMS file."""
    segments = _Segments(path)
    with TdmsFile.open(path, raw_timestamps=True) as file:
        channels = [(group, one) for group in file.groups() for one in group.channels() if len(one)]
        pieces = {(group.name, one.name): segments.pieces(one.path) for group, one in channels}
        clocks = {group.name: _clock(group) for group, _ in channels}
        notes = [CUT] if file.file_status.incomplete_final_segment else []
    known = [clock for clock in clocks.values() if clock is not None]
    stamps = [given.get(START) for own in pieces.values() for _, given in own] + [times[0] for _, _, times in known]
    start = min((at for stamp in stamps if (at := _nanoseconds(stamp)) is not None), default=None)
    bare = [one for name, unit, one in known if one.dtype.kind in "iuf" and not (unit or unit_behind(name)[1])]
    notes += doubts(np.asarray(times[[0, -1]], dtype=np.float64) for times in bare)
    late = ["/".join(key) for key, own in pieces.items() if STEP in own[0][1] and START not in own[0][1]]
    if late and start is not None:
        notes.append(f"Channels without a start are taken to begin with the first of the others: {several(late, 6)}.")

    def loaded(label: str, group: str, name: str) -> Channel:
        own = pieces[group, name]
        scales = [[pair for pair in given.items() if pair[0].startswith(("NI_Scal", "unit_"))] for _, given in own]
        if any(scale != scales[0] for scale in scales):
            raise DataError(
                f"channel {name!r} is scaled anew within the file, and npTDMS scales all of it by the last numbers; "
                "expected one scale; split the file where it was calibrated"
            )
        time = _waveform(own, start or 0) if all(given.get(STEP) for _, given in own) else None
        if time is None and (clock := clocks[group]) is not None:
            is_stamped = hasattr(clock[2], "as_datetime64")
            time = seconds_since(start or 0, _nanoseconds(clock[2])) if is_stamped else seconds_in(*clock)
        if time is None:
            raise DataError(f"channel {name!r} has no times: no {STEP} and no channel 'time' beside it; add one")
        with TdmsFile.open(path, raw_timestamps=True) as file:
            return Channel(label, str(own[-1][1].get(UNIT, "")), time, file[group][name][:])

    # channel C of group A/B and B/C of A would both be A/B/C
    labels = told_apart(["/".join(key) for key in pieces], ["'{}'/'{}'".format(*key) for key in pieces])
    loaders = {label: functools.partial(loaded, label, *key) for label, key in zip(labels, pieces, strict=True)}
    return Recording("TDMS", loaders, start, tuple(notes))


def _clock(group: Any) -> tuple[str, str, Any] | None:
    """Return name, unit and numbers of the channel that holds the times of those beside it."""
    units = {one.name: str(one.properties.get(UNIT, "")) for one in group.channels() if len(one)}
    name = times_among(units)
    return None if name is None else (name, units[name], group[name][:])


def _nanoseconds(stamps: Any) -> Any:
    return stamps.as_datetime64("ns").astype(np.int64) if hasattr(stamps, "as_datetime64") else None


def _waveform(pieces: Pieces, zero: int) -> Floats:
    """Return the times of a waveform; a segment that repeats the start of the one before goes on from there."""
    found, last, n_before = [], None, 0
    for n, given in pieces:
        at = (_nanoseconds(given.get(START)), given.get(OFFSET, 0.0))
        n_before = n_before if at == last else 0
        begin = ((at[0] or zero) - zero) / 1e9 + at[1]
        found.append(begin + given[STEP] * np.arange(n_before, n_before + n))
        last, n_before = at, n_before + n
    return np.concatenate(found)
