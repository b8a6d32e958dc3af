"""TDMS by npTDMS: groups of channels, each a waveform, or beside a channel of times in its group.

npTDMS stamps and scales every sample from the properties that stand last in the file. A file that was stopped and gone
on with has several starts: each segment is stamped here by its own. Where segments are scaled by different numbers,
no sample before the last change is right, so the channel is refused.
"""

import functools
from pathlib import Path
from typing import Any

import numpy as np

from octmip.errors import DataError, needed_by
from octmip.recordings.recording import Channel, Floats, Recording, seconds_since

with needed_by("a recording of TDMS"):
    from nptdms import TdmsFile
    from nptdms.reader import TdmsReader, _number_of_segment_values

TIMES = ("time", "timestamp", "timestamps", "zeit")


class _Segments(TdmsReader):  # type: ignore[misc]
    """The properties of each segment, which `TdmsFile` keeps of the last one alone."""

    def __init__(self, path: Path) -> None:
        super().__init__(path)
        self.given: list[dict[str, dict[str, Any]]] = []
        self.read_metadata(require_segment_indexes=True)
        self.close()

    def _update_object_properties(self, properties: Any) -> None:
        super()._update_object_properties(properties)
        self.given.append({path: dict(pairs) for path, pairs in (properties or {}).items()})

    def pieces(self, path: str) -> list[tuple[int, dict[str, Any]]]:
        """Return the samples of a channel by segment, and the properties that it has there."""
        found, now = [], dict[str, Any]()
        for segment, given in zip(self._segments, self.given, strict=True):
            now = now | given.get(path, {})
            place = segment.object_index.get(path)
            n = 0 if place is None else int(_number_of_segment_values(segment.ordered_objects[place], segment))
            found += [(n, now)] if n else []
        return found


def read(path: Path) -> Recording:
    """Return the channels of a TDMS file."""
    segments = _Segments(path)
    file = TdmsFile.read_metadata(path, raw_timestamps=True)
    listed = [one for group in file.groups() for one in group.channels()]
    pieces = {one.path: segments.pieces(one.path) for one in listed}
    starts = [at for found in pieces.values() for _, properties in found if (at := _start(properties)) is not None]
    start = min(starts, default=None)

    def loaded(group: str, name: str) -> Channel:
        with TdmsFile.open(path, raw_timestamps=True) as file:
            channel = file[group][name]
            return series(channel, pieces[channel.path], file[group].channels())

    def series(channel: Any, own: list[tuple[int, dict[str, Any]]], group: Any) -> Channel:
        scales = [{k: v for k, v in given.items() if k.startswith("NI_Scal")} for _, given in own]
        if any(scale != scales[0] for scale in scales):
            raise DataError(
                f"channel {channel.name!r} is scaled anew within the file, and npTDMS scales all of it by the last "
                "numbers; expected one scale; split the file where it was calibrated"
            )
        time = _waveform(own, start or 0)
        time = _beside(channel, group) if time is None else time
        name = f"{channel.group_name}/{channel.name}"
        return Channel(name, str(channel.properties.get("unit_string", "")), time, channel[:])

    names = [(one.group_name, one.name) for one in listed if pieces[one.path]]
    notes = ("The last segment is shorter than it says: the file was cut.",) * file.file_status.incomplete_final_segment
    return Recording("TDMS", {"/".join(pair): functools.partial(loaded, *pair) for pair in names}, start, notes)


def _start(properties: dict[str, Any]) -> int | None:
    at = properties.get("wf_start_time")
    return None if at is None else int(at.as_datetime64("ns").astype(np.int64))


def _waveform(pieces: list[tuple[int, dict[str, Any]]], zero: int) -> Floats | None:
    """Return the times of a waveform; a segment that repeats the start of the one before goes on from there."""
    found, last, n_before = [], None, 0
    for n, properties in pieces:
        step, offset = properties.get("wf_increment"), properties.get("wf_start_offset", 0.0)
        if not step:
            return None
        at = _start(properties)
        n_before = n_before if (at, offset) == last else 0
        since = 0.0 if at is None else (at - zero) / 1e9
        found.append(since + offset + step * np.arange(n_before, n_before + n))
        last, n_before = (at, offset), n_before + n
    return np.concatenate(found)


def _beside(channel: Any, group: Any) -> Floats:
    """Return the times that another channel of the group has."""
    for other in group:
        if other is not channel and len(other) == len(channel) and other.name.strip().lower() in TIMES:
            times = other[:]
            if times.dtype.kind in "fiu":
                return np.asarray(times, dtype=np.float64)
            stamps = times.as_datetime64("ns").astype(np.int64)
            return seconds_since(int(stamps[0]), stamps)
    raise DataError(
        f"channel {channel.name!r} has no times: neither wf_increment nor a channel {TIMES[0]!r} beside it; add one"
    )
