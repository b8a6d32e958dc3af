"""ULog of PX4 by pyulog: topics of fields, each topic with its own times. The format has no units.

A topic that was subscribed to again under a new number stands in `ULog.data_list` in pieces, of which
`ULog.get_dataset` gives one; here the pieces are one series in the order of time.
"""

import functools
from pathlib import Path

import numpy as np

from octmip.errors import needed_by
from octmip.recordings.recording import Channel, Recording

with needed_by("a recording of ULog"):
    from pyulog import ULog

MICROSECOND = 1e-6


def read(path: Path) -> Recording:
    """Return the fields of a log as TOPIC/FIELD, of the second instance as TOPIC.1/FIELD."""
    log = ULog(str(path))
    topics: dict[str, list[dict[str, np.ndarray]]] = {}
    for piece in log.data_list:
        name = f"{piece.name}.{piece.multi_id}" if piece.multi_id else piece.name
        topics.setdefault(name, []).append(piece.data)
    start = min((int(data["timestamp"][0]) for parts in topics.values() for data in parts), default=0)

    def loaded(topic: str, field: str) -> Channel:
        parts = sorted(topics[topic], key=lambda data: int(data["timestamp"][0]))
        stamps = np.concatenate([data["timestamp"] for data in parts]).astype(np.int64) - start
        time = np.asarray(stamps * MICROSECOND, dtype=np.float64)
        return Channel(f"{topic}/{field}", "", time, np.concatenate([data[field] for data in parts]))

    loaders = {
        f"{topic}/{field}": functools.partial(loaded, topic, field)
        for topic, parts in topics.items()
        for field in parts[0]
        if field != "timestamp" and all(field in data for data in parts)
    }
    split = [name for name, parts in topics.items() if len(parts) > 1]
    notes = [
        f"Topic {name} was subscribed to {len(topics[name])} times; its pieces follow one another." for name in split
    ]
    if log.dropouts:
        lost = sum(one.duration for one in log.dropouts) / 1000.0
        notes.append(f"The logger lost {len(log.dropouts)} stretches, {lost:.3g} s in all; nothing is filled.")
    if log.file_corruption:
        notes.append("pyulog calls the log damaged and left rows or whole topics out; a channel may lack samples.")
    return Recording("ULog", loaders, notes=tuple(notes))
