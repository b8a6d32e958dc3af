"""Messages of robots as channels: every number in a message, by its place in it, at the time when it was logged."""

import functools
from collections.abc import Iterable, Iterator
from typing import Any

import numpy as np

from octmip.recordings.recording import Channel, Recording, seconds_since

MOST_FIELDS = 64
"""Numbers of one message that become channels: images and point clouds are none."""


def recorded(form: str, messages: Iterable[tuple[str, int, Any]]) -> Recording:
    """Return the channels of messages: topic, instant [ns since 1970] and content.

    A number that some messages of a topic lack is missing there. Instants are those of logging, which a header's own
    stamp may precede.
    """
    stamps: dict[str, list[int]] = {}
    columns: dict[str, dict[str, list[tuple[int, float]]]] = {}
    for topic, instant, content in messages:
        own = stamps.setdefault(topic, [])
        for place, value in _numbers(content):
            columns.setdefault(topic, {}).setdefault(place, []).append((len(own), value))
        own.append(instant)
    start = min((own[0] for own in stamps.values()), default=0)

    def loaded(topic: str, place: str) -> Channel:
        values = np.full(len(stamps[topic]), np.nan)
        rows, numbers = zip(*columns[topic][place], strict=True)
        values[list(rows)] = numbers
        return Channel(f"{topic}/{place}", "", seconds_since(start, stamps[topic]), values)

    loaders = {
        f"{topic}/{place}": functools.partial(loaded, topic, place) for topic, own in columns.items() for place in own
    }
    notes = ("Times are those of logging, not the stamps in the messages' headers.",)
    return Recording(form, loaders, start, notes if loaders else ())


def _numbers(content: Any, place: str = "") -> Iterator[tuple[str, float]]:
    """Yield the numbers of a message with their places, such as "pose.position.x" or "data.0"."""
    if isinstance(content, (bool, int, float, np.number)):
        yield place or "data", float(content)
        return
    parts: Iterable[tuple[Any, Any]]
    if isinstance(content, dict):
        parts = content.items()
    elif isinstance(content, (list, tuple, np.ndarray)):
        parts = enumerate(content) if len(content) <= MOST_FIELDS else ()
    else:
        parts = ((key, getattr(content, key)) for key in getattr(content, "__dataclass_fields__", ()))
    for key, value in parts:
        if not str(key).startswith("__"):
            yield from _numbers(value, f"{place}.{key}" if place else str(key))
