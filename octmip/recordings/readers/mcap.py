"""MCAP by the package mcap: messages in JSON, or in ROS 2's CDR by the definitions that the file holds.

mcap unpacks chunks and reads what stands about messages; records are parted here, in a tenth of the time.
"""

import functools
import json
import mmap
import struct
from collections.abc import Iterator, Sequence
from io import BytesIO
from pathlib import Path
from typing import Any

from octmip.errors import DataError, needed_by
from octmip.recordings.readers.messages import Columns, Decode, columns_of, decoded
from octmip.recordings.recording import Recording

with needed_by("a recording of MCAP"):
    from mcap.data_stream import ReadDataStream
    from mcap.opcode import Opcode
    from mcap.records import Channel, Chunk, Schema
    from mcap.stream_reader import get_chunk_data_stream
    from rosbags.typesys import Stores, get_types_from_msg, get_typestore

    from octmip.recordings.readers.ros import Decoder

MAGIC = 8
"""Bytes before the first record."""
HEAD, MESSAGE = struct.Struct("<BQ"), struct.Struct("<HIQQ")
"""Of a record: its kind and length; of a message: channel, sequence, time of logging, time of sending."""


def read(path: Path) -> Recording:
    """Return the numbers in the messages of a file as TOPIC/FIELD."""
    return decoded("MCAP", _messages(path))


def _messages(path: Path) -> Iterator[tuple[str, int, bytes, Decode]]:
    schemas, topics, others = dict[int, Any](), dict[int, tuple[str, Decode | None]](), set[str]()
    decode: Decode | None
    decoder = functools.cache(_decoder)
    with path.open("rb") as file, mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ) as content:
        for kind, record in _records(content, MAGIC):
            if kind == Opcode.MESSAGE:
                number, _, instant, _ = MESSAGE.unpack_from(record)
                topic, decode = topics[number]
                if decode is not None:
                    yield topic, instant, record[MESSAGE.size :], decode
            elif kind == Opcode.SCHEMA:
                schema = Schema.read(ReadDataStream(BytesIO(record)))
                schemas[schema.id] = schema
            elif kind == Opcode.CHANNEL:
                own = Channel.read(ReadDataStream(BytesIO(record)))
                schema, decode = schemas.get(own.schema_id), _json if own.message_encoding == "json" else None
                if own.message_encoding == "cdr" and schema is not None and schema.encoding == "ros2msg":
                    decode = decoder(schema.name, schema.data)
                others |= {own.message_encoding} if decode is None else set()
                topics[own.id] = own.topic, decode
    if others and not any(decode for _, decode in topics.values()):
        raise DataError(
            f"{path} holds messages in {', '.join(sorted(others))}; expected JSON or ROS 2 (cdr); convert it"
        )


def _records(content: Any, at: int) -> Iterator[tuple[int, bytes]]:
    """Yield kind and bytes of the records up to the end of the data, those in chunks one by one."""
    while at < len(content):
        kind, length = HEAD.unpack_from(content, at)
        at, begin = at + HEAD.size + length, at + HEAD.size
        if at > len(content):
            raise EOFError("the file or a chunk ends within a record")
        if kind == Opcode.DATA_END:
            return
        if kind == Opcode.CHUNK:
            stream, size = get_chunk_data_stream(Chunk.read(ReadDataStream(BytesIO(content[begin:at]))))
            yield from _records(stream.read(size), 0)
        else:
            yield kind, content[begin:at]


def _json(messages: Sequence[bytes]) -> Columns:
    try:  # all at once: a call of each takes as long again
        contents = json.loads(b"[" + b",".join(messages) + b"]")
    except ValueError:
        contents = []
    return columns_of(contents if len(contents) == len(messages) else [json.loads(message) for message in messages])


def _decoder(name: str, text: bytes) -> Decode:
    """Return what decodes a type, which ROS 2 calls std_msgs/msg/Float64 and some files std_msgs/Float64."""
    store = get_typestore(Stores.EMPTY)
    store.register(get_types_from_msg(text.decode(), name))
    return Decoder(store, name if "/msg/" in name else name.replace("/", "/msg/", 1), is_cdr=True)
