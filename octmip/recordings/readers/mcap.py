"""MCAP by the package mcap: messages in JSON, or in ROS 2's CDR by the definitions that the file holds.

mcap reads the file and unpacks its chunks; the messages in a chunk are taken here, in a tenth of the time.
"""

import functools
import json
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
    from mcap.records import Channel, Chunk, Message, Schema
    from mcap.stream_reader import StreamReader, get_chunk_data_stream
    from rosbags.typesys import Stores, get_types_from_msg, get_typestore

    from octmip.recordings.readers.ros import Decoder

HEAD, MESSAGE = struct.Struct("<BQ"), struct.Struct("<HIQQ")
"""Of a record: its kind and length; of a message: channel, sequence, time of logging, time of sending."""


def read(path: Path) -> Recording:
    """Return the numbers in the messages of a file as TOPIC/FIELD."""
    return decoded("MCAP", _messages(path))


def _messages(path: Path) -> Iterator[tuple[str, int, bytes, Decode]]:
    schemas, topics, others = dict[int, Any](), dict[int, tuple[str, Decode | None]](), set[str]()
    decode: Decode | None
    decoder = functools.cache(_decoder)
    with path.open("rb") as file:
        for record in _records(file):
            if isinstance(record, Schema):
                schemas[record.id] = record
            elif isinstance(record, Channel):
                schema, decode = schemas.get(record.schema_id), _json if record.message_encoding == "json" else None
                if record.message_encoding == "cdr" and schema is not None and schema.encoding == "ros2msg":
                    decode = decoder(schema.name, schema.data)
                others |= {record.message_encoding} if decode is None else set()
                topics[record.id] = record.topic, decode
            else:
                number, instant, content = record
                topic, decode = topics[number]
                if decode is not None:
                    yield topic, instant, content, decode
    if others and not any(decode for _, decode in topics.values()):
        raise DataError(
            f"{path} holds messages in {', '.join(sorted(others))}; expected JSON or ROS 2 (cdr); convert it"
        )


def _records(file: Any) -> Iterator[Any]:
    """Yield schemas, channels, and messages as number of the channel, instant [ns] and content."""
    for record in StreamReader(file, emit_chunks=True).records:
        if isinstance(record, Message):
            yield record.channel_id, record.log_time, record.data
        if not isinstance(record, Chunk):
            yield from [record] if isinstance(record, Schema | Channel) else []
            continue
        stream, size = get_chunk_data_stream(record)
        content, at = stream.read(size), 0
        while at < size:
            kind, length = HEAD.unpack_from(content, at)
            at, begin = at + HEAD.size + length, at + HEAD.size
            if kind == Opcode.MESSAGE:
                number, _, instant, _ = MESSAGE.unpack_from(content, begin)
                yield number, instant, content[begin + MESSAGE.size : at]
            elif kind in (Opcode.SCHEMA, Opcode.CHANNEL):
                own = Schema if kind == Opcode.SCHEMA else Channel
                yield own.read(ReadDataStream(BytesIO(content[begin:at])))
        if at != size:
            raise EOFError("a chunk ends within a message")


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
