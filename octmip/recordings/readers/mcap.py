"""MCAP by the package mcap: messages in JSON, or in ROS 2's CDR by the definitions that the file holds."""

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from octmip.errors import DataError, needed_by
from octmip.recordings.readers.fields import recorded
from octmip.recordings.recording import Recording

with needed_by("a recording of MCAP"):
    from mcap.reader import make_reader
    from rosbags.typesys import Stores, get_types_from_msg, get_typestore


def read(path: Path) -> Recording:
    """Return the numbers in the messages of a file as TOPIC/FIELD."""
    return recorded("MCAP", _messages(path))


def _messages(path: Path) -> Iterator[tuple[str, int, Any]]:
    store, known, others = get_typestore(Stores.EMPTY), set[str](), set[str]()
    with path.open("rb") as file:
        for schema, channel, message in make_reader(file).iter_messages():
            if channel.message_encoding == "json":
                yield channel.topic, message.log_time, json.loads(message.data)
            elif channel.message_encoding == "cdr" and schema is not None and schema.encoding == "ros2msg":
                if schema.name not in known:
                    store.register(get_types_from_msg(schema.data.decode(), schema.name))
                    known.add(schema.name)
                yield channel.topic, message.log_time, store.deserialize_cdr(message.data, _full(schema.name))
            else:
                others.add(channel.message_encoding)
    if others and not known:
        raise DataError(
            f"{path} holds messages in {', '.join(sorted(others))}; expected JSON or ROS 2 (cdr); convert it"
        )


def _full(name: str) -> str:
    """Return a type's name as ROS 2 writes it: std_msgs/Float64 is std_msgs/msg/Float64."""
    return name if "/msg/" in name else name.replace("/", "/msg/", 1)
