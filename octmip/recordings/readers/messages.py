"""Messages as channels: every number in a message, by its place in it, at the time of its message."""

import functools
import itertools
from array import array
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import MISSING, fields, is_dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from octmip.recordings.recording import Channel, Floats, Recording

MOST_FIELDS = 64
"""Numbers of one message that become channels: images and point clouds are none."""
BATCH = 50_000
"""Messages of a topic that are decoded at once."""
MICRO, NANO = 1e6, 1e9
"""Ticks of a clock in a second."""
Rows = NDArray[np.int64]
Column = tuple[Rows, Floats]
"""The messages of a batch that have a number, counted from 0, and the numbers."""
Columns = dict[str, Column]
"""By the place of the number in its message."""
Decode = Callable[[Sequence[bytes]], Columns]
Topic = tuple[Rows, Sequence[str], Callable[[str], tuple[str, NDArray[Any]]]]
"""Stamps (n,) of its messages in ticks, its fields, and what returns unit and values (n,) of a field."""


def of_topics(form: str, topics: Mapping[str, Topic], ticks: float, notes: Sequence[str] = ()) -> Recording:
    """Return the fields of topics as TOPIC/FIELD; a clock of nanoseconds counts since 1970."""
    start = min((int(stamps[0]) for stamps, *_ in topics.values()), default=0)

    def loaded(topic: str, field: str) -> Channel:
        stamps, _, read = topics[topic]
        unit, values = read(field)
        return Channel(f"{topic}/{field}", unit, (stamps - start) / ticks, values)

    pairs = [(topic, field) for topic, (_, names, _) in topics.items() for field in names]
    loaders = {"/".join(pair): functools.partial(loaded, *pair) for pair in pairs}
    return Recording(form, loaders, start if ticks == NANO else None, tuple(notes))


def decoded(form: str, messages: Iterable[tuple[str, int, bytes, Decode]]) -> Recording:
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
    topics = dict[str, Topic]()
    for topic, own in columns.items():
        instants = np.array(stamps[topic], dtype=np.int64)
        order = np.argsort(instants, kind="stable")
        topics[topic] = instants[order], tuple(own), functools.partial(_filled, order, own)
    notes = ("Times are those of logging, not the stamps in the messages' headers.",) if topics else ()
    return of_topics(form, topics, NANO, notes)


def _filled(order: Rows, columns: Mapping[str, Sequence[Column]], place: str) -> tuple[str, Floats]:
    values = np.full(len(order), np.nan)
    for rows, numbers in columns[place]:
        values[rows] = numbers
    return "", values[order]


def field_of(content: NDArray[np.uint8], at: Rows, begin: int, kind: str) -> NDArray[Any]:
    """Return the values (n,) of a kind so many bytes behind places (n,) in the bytes of messages."""
    form = np.dtype([("field", kind)])
    return np.asarray(content[at[:, None] + np.arange(begin, begin + form.itemsize)].view(form)["field"][:, 0])


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
    kinds = dict.fromkeys(map(type, contents))
    for kind in kinds:
        is_own = [type(one) is kind for one in contents] if len(kinds) > 1 else ()
        own, at = (list(itertools.compress(contents, is_own)), rows[list(is_own)]) if is_own else (contents, rows)
        if issubclass(kind, bool | int | float | np.number):
            yield place or "data", (at, np.array(own, dtype=np.float64))
            continue
        for key, (numbers, values) in _by_key(at, own if issubclass(kind, dict) else list(map(_parts, own))).items():
            if not str(key).startswith("__"):
                yield from _numbers(numbers, values, f"{place}.{key}" if place else str(key))


def _parts(content: Any) -> Mapping[Any, Any]:
    """Return the elements of a list that is no image, or the fields of a message that are no constants."""
    if isinstance(content, list | tuple | np.ndarray):
        return dict(enumerate(content)) if len(content) <= MOST_FIELDS else {}
    keys = [one.name for one in fields(content) if one.default is MISSING] if is_dataclass(content) else []
    return {key: getattr(content, key) for key in keys}


def _by_key(rows: Rows, contents: Sequence[Mapping[Any, Any]]) -> Mapping[Any, tuple[Rows, list[Any]]]:
    """Return the values of each key, and the messages that have it."""
    if all(one.keys() == contents[0].keys() for one in contents):
        return {key: (rows, [one[key] for one in contents]) for key in contents[0]}
    found: dict[Any, tuple[list[int], list[Any]]] = {}
    for k, one in zip(rows.tolist(), contents, strict=True):
        for key, value in one.items():
            numbers, values = found.setdefault(key, ([], []))
            numbers.append(k)
            values.append(value)
    return {key: (np.array(numbers), values) for key, (numbers, values) in found.items()}
