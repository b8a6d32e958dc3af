"""Bags of ROS by rosbags: a .bag of ROS 1, or a .db3 of ROS 2 with its metadata.yaml beside it."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

from octmip.errors import DataError, needed_by
from octmip.recordings.readers.fields import recorded
from octmip.recordings.recording import Recording

with needed_by("a recording of ROS"):
    from rosbags.highlevel import AnyReader
    from rosbags.typesys import Stores, get_typestore


def read(path: Path) -> Recording:
    """Return the numbers in the messages of a bag as TOPIC/FIELD."""
    if path.suffix != ".bag" and not path.with_name("metadata.yaml").is_file():
        raise DataError(
            f"{path} has no metadata.yaml beside it; expected the folder of a ROS 2 bag; copy the whole folder"
        )
    return recorded("rosbag", _messages(path))


def _messages(path: Path) -> Iterator[tuple[str, int, Any]]:
    bag = path if path.suffix == ".bag" else path.parent
    with AnyReader([bag], default_typestore=get_typestore(Stores.LATEST)) as reader:
        for connection, instant, data in reader.messages():
            yield connection.topic, instant, reader.deserialize(data, connection.msgtype)
