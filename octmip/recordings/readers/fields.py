"""Messages of robots as channels: every number in a message, by its place in it, at the time when it was logged."""

import functools
import itertools
from array import array
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import MISSING, fields, is_dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from octmip.recordings.recording import Channel, Floats, Recording, seconds_since

MOST_FIELDS = 64
"""Numbers of one message that become channels: images and point clouds are none."""
BATCH = 50_000
"""Messages of a topic that are decoded at once."""
Rows = NDArray[np.int64]
Column = tuple[Rows, Floats]
"""The messages of a batch that have a number, counted from 0, and the numbers."""
Columns = dict[str, Column]
"""By the place of the number in its message."""
Decode = Callable[[Sequence[bytes]], Columns]


def recorded(form: str, messages: Iterable[tuple[str, int, bytes, Decode]]) -> Recording:
    """Return the channels of messages: topic, instant [ns since 1970], content and what decodes a batch of contents.

    A number that some messages of a topic lack is missing there. Instants are those of logging, which a header's own
    stamp may precede.
    """
    stamps: dict[str, array[int]] = {}
    waiting: dict[str, tuple[Decode, list[bytes]]] = {}
    columns: dict[str, dict[str, list[Column]]] = {}

    def flush(topic: str) -> None:
        decode, contents = waiting.pop(topic)
        for place, (rows, numbers) in decode(contents).items():
            pair = rows + len(stamps[topic]) - len(contents), numbers
            columns.setdefault(topic, {}).setdefault(place, []).append(pair)

    for topic, instant, content, decode in messages:
        if topic in waiting and (waiting[topic][0] != decode or len(waiting[topic][1]) == BATCH):
            flush(topic)
        waiting.setdefault(topic, (decode, []))[1].append(content)
        stamps.setdefault(topic, array("q")).append(instant)
    for topic in tuple(waiting):
        flush(topic)
    instants = {topic: np.array(own, dtype=np.int64) for topic, own in stamps.items()}
    start = min((int(own.min()) for own in instants.values()), default=0)

    def loaded(topic: str, place: str) -> Channel:
        order, values = np.argsort(instants[topic], kind="stable"), np.full(len(instants[topic]), np.nan)
        for rows, numbers in columns[topic][place]:
            values[rows] = numbers
        return Channel(f"{topic}/{place}", "", seconds_since(start, instants[topic][order]), values[order])

    loaders = {
        f"{topic}/{place}": functools.partial(loaded, topic, place) for topic, own in columns.items() for place in own
    }
    notes = ("Times are those of logging, not the stamps in the messages' headers.",)
    return Recording(form, loaders, start, notes if loaders else ())


def columns_of(contents: Sequence[Any]) -> Columns:
    """Return the numbers of decoded messages with their places, such as "pose.position.x" or "data.0"."""
    return joined(_numbers(np.arange(len(contents)), contents, ""))


def joined(parts: Iterable[tuple[str, Column]]) -> Columns:
    """Return columns whose parts are one behind another."""
    found: dict[str, list[Column]] = {}
    for place, part in parts:
        found.setdefault(place, []).append(part)
    return {
        place: (np.concatenate([rows for rows, _ in own]), np.concatenate([numbers for _, numbers in own]))
        for place, own in found.items()
    }


def _numbers(rows: Rows, contents: Sequence[Any], place: str) -> Iterator[tuple[str, Column]]:
    """Yield the numbers of contents of the same place, kind by kind: what all messages have alike takes one step."""
    for kind in dict.fromkeys(map(type, contents)):
        is_own = [type(one) is kind for one in contents]
        own, at = (contents, rows) if all(is_own) else (list(itertools.compress(contents, is_own)), rows[is_own])
        if issubclass(kind, bool | int | float | np.number):
            yield place or "data", (at, np.array(own, dtype=np.float64))
            continue
        parts: Iterable[Iterable[tuple[Any, Any]]]
        if issubclass(kind, dict):
            parts = (one.items() for one in own)
            if all(one.keys() == own[0].keys() for one in own):
                for key in own[0]:
                    if not key.startswith("__"):
                        yield from _numbers(at, [one[key] for one in own], f"{place}.{key}" if place else key)
                continue
        elif issubclass(kind, list | tuple | np.ndarray):
            parts = (enumerate(one) if len(one) <= MOST_FIELDS else () for one in own)
        else:
            keys = [one.name for one in fields(kind) if one.default is MISSING] if is_dataclass(kind) else []
            parts = ([(key, getattr(one, key)) for key in keys] for one in own)
        inner: dict[Any, tuple[list[int], list[Any]]] = {}
        for k, part in zip(at.tolist(), parts, strict=True):
            for key, value in part:
                numbers, values = inner.setdefault(key, ([], []))
                numbers.append(k)
                values.append(value)
        for key, (numbers, values) in inner.items():
            if not str(key).startswith("__"):
                yield from _numbers(np.array(numbers), values, f"{place}.{key}" if place else str(key))
