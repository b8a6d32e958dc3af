"""ULog of PX4 by pyulog: topics of fields, each topic with its own times. The format has no units.

A topic that was subscribed to again under a new number stands in `ULog.data_list` in pieces, of which
`ULog.get_dataset` gives one; here the pieces are one series in the order of time.
"""

import functools
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from octmip.errors import needed_by
from octmip.recordings.readers.messages import MICRO, Topic, of_topics
from octmip.recordings.recording import Recording

with needed_by("a recording of ULog"):
    from pyulog import ULog

STAMP = "timestamp"


def read(path: Path) -> Recording:
    """Return the fields of a log as TOPIC/FIELD, of the second instance as TOPIC.1/FIELD."""
    log = ULog(str(path))
    found: dict[str, list[dict[str, Any]]] = {}
    for piece in log.data_list:
        found.setdefault(f"{piece.name}.{piece.multi_id}" if piece.multi_id else piece.name, []).append(piece.data)
    notes = [
        f"Topic {name} was subscribed to {len(parts)} times; its pieces follow one another."
        for name, parts in found.items()
        if len(parts) > 1
    ]
    if log.dropouts:
        lost = sum(one.duration for one in log.dropouts) / 1000.0
        notes.append(f"The logger lost {len(log.dropouts)} stretches, {lost:.3g} s in all; nothing is filled.")
    if log.file_corruption:
        notes.append("pyulog calls the log damaged and left rows or whole topics out; a channel may lack samples.")
    topics = dict[str, Topic]()
    for name, parts in found.items():
        parts.sort(key=lambda data: int(data[STAMP][0]))
        names = [field for field in parts[0] if field != STAMP and all(field in data for data in parts)]
        topics[name] = _joined(parts, STAMP)[1].astype(np.int64), names, functools.partial(_joined, parts)
    return of_topics("ULog", topics, MICRO, notes)


def _joined(parts: Sequence[Mapping[str, Any]], field: str) -> tuple[str, NDArray[Any]]:
    return "", np.concatenate([data[field] for data in parts])
