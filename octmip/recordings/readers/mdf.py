"""MDF 3 and 4 (.mf4, .mdf, .dat) by asammdf: groups of channels, each with a master channel of times.

`MDF.get` drops the samples whose invalidation bit is set, and `to_dataframe` interpolates over them: every sample stays
here, with its bit.
"""

import functools
from pathlib import Path
from typing import Any

import numpy as np

from octmip.errors import DataError, needed_by
from octmip.recordings.recording import Channel, Recording, told_apart

with needed_by("a recording of MDF"):
    from asammdf import MDF

TIME_MASTER = 1
"""Kind of a master channel that holds times, not angles or distances."""


def read(path: Path) -> Recording:
    """Return the channels of an MDF file; a name that several groups have gets the group's number before it."""
    with MDF(path) as file:
        groups: Any = file.groups
        start = int(file.header.start_time.timestamp() * 1e6) * 1000
        places = [
            (channel.name, group, k)
            for group, own in enumerate(groups)
            for k, channel in enumerate(own.channels)
            if k != file.masters_db.get(group) and own.channel_group.cycles_nr
        ]
    labels = told_apart([name for name, _, _ in places], [f"{group}/{name}" for name, group, _ in places])

    def loaded(name: str, group: int, k: int) -> Channel:
        with MDF(path) as file:
            signal = file.get(group=group, index=k, ignore_invalidation_bits=True)
        master = signal.master_metadata
        if master is not None and master[1] not in (0, TIME_MASTER):
            raise DataError(f"channel {name!r} is recorded over {master[0]!r}, no time; expected a channel over time")
        invalid = signal.invalidation_bits
        valid = None if invalid is None else ~np.asarray(invalid, dtype=bool)
        return Channel(name, signal.unit or "", signal.timestamps, signal.samples, valid)

    loaders = {one: functools.partial(loaded, one, *place[1:]) for one, place in zip(labels, places, strict=True)}
    return Recording("MDF", loaders, start)
