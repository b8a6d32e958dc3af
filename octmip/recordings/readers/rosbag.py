"""Bags of ROS by rosbags: a .bag of ROS 1, or a .db3 of ROS 2 with its metadata.yaml beside it."""

import heapq
import itertools
import struct
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from octmip.errors import DataError, needed_by
from octmip.recordings.readers.messages import Decode, decoded
from octmip.recordings.recording import Recording

with needed_by("a recording of ROS"):
    from rosbags.highlevel import AnyReader
    from rosbags.typesys import Stores, get_typestore

    from octmip.recordings.readers.ros import Decoder

LENGTH = struct.Struct("<I")


def read(path: Path) -> Recording:
    """Return the numbers in the messages of a bag as TOPIC/FIELD."""
    if path.suffix != ".bag" and not path.with_name("metadata.yaml").is_file():
        raise DataError(
            f"{path} has no metadata.yaml beside it; expected the folder of a ROS 2 bag; copy the whole folder"
        )
    return decoded("rosbag", _messages(path))


def _messages(path: Path) -> Iterator[tuple[str, int, bytes, Decode]]:
    bag, known = path if path.suffix == ".bag" else path.parent, dict[str, Decode]()
    with AnyReader([bag], default_typestore=get_typestore(Stores.LATEST)) as reader:
        for connection, instant, data in reader.messages() if reader.is2 else _of_chunks(reader.readers[0]):
            kind = connection.msgtype
            if kind not in known:
                known[kind] = Decoder(reader.typestore, kind, is_cdr=reader.is2)
            yield connection.topic, instant, data, known[kind]


def _of_chunks(bag: Any) -> Iterator[tuple[Any, int, bytes]]:
    """Yield the messages of a bag of ROS 1 by its index, in an eighth of the time that `Reader.messages` takes."""
    place, content = -1, b""
    for (instant, chunk, at), connection in heapq.merge(
        *(zip(bag.indexes[one.id], itertools.repeat(one)) for one in bag.connections), key=lambda pair: pair[0]
    ):
        if chunk != place:
            bag.bio.seek(bag.chunks[chunk].datapos)
            place, content = chunk, bag.chunks[chunk].decompressor(bag.bio.read(bag.chunks[chunk].datasize))
        while True:  # what the index names may be a connection, before its first message
            body = at + 4 + LENGTH.unpack_from(content, at)[0]
            begin, end = body + 4, body + 4 + LENGTH.unpack_from(content, body)[0]
            if b"op=\x02" in content[at:body]:
                break
            if b"op=\x07" not in content[at:body]:
                raise DataError("the index of the bag names what is no message; expected one; index it again")
            at = end
        if end > len(content):
            raise EOFError("a chunk ends within a message")
        yield connection, instant, content[begin:end]
