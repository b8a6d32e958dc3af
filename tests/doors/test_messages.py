"""Messages that are decoded many at once are those that their library decodes one by one."""

import functools
import io
import json
import struct
from dataclasses import MISSING, fields, is_dataclass
from types import SimpleNamespace

import numpy as np
import pytest
from mcap.reader import make_reader
from mcap.writer import Writer as McapWriter
from rosbags.highlevel import AnyReader
from rosbags.interfaces import Nodetype
from rosbags.rosbag1 import Writer
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from octmip.errors import DataError
from octmip.recordings import recording
from octmip.recordings.readers import ros
from octmip.recordings.readers.mcap import _json
from octmip.recordings.readers.messages import columns_of, decoded
from octmip.recordings.readers.ros import Decoder
from octmip.recordings.readers.rosbag import _of_chunks

MIXED = """bool a
float64 b
int8 c
float32[3] d
string e
uint16 f
float64[] g
byte h
char i
geometry_msgs/Point[] p
string[] s
uint8[70] big
int64 j
geometry_msgs/Point[2] q
"""
NAMES = ["sensor_msgs/msg/Imu", "sensor_msgs/msg/JointState", "std_msgs/msg/Float64MultiArray", "std_msgs/msg/Bool"]
NAMES += ["trajectory_msgs/msg/JointTrajectory", "sensor_msgs/msg/PointCloud2", "std_msgs/msg/Empty", "beam/msg/Mixed"]
NAMES += ["sensor_msgs/msg/NavSatStatus"]  # whose constants are no channels
TYPES = {"byte": "int8", "char": "uint8"}


def store_of(number):
    store = get_typestore(number)
    store.register(get_types_from_msg(MIXED, "beam/msg/Mixed"))
    return store


def random_field(rng, store, form, n):
    """Return a value of a field whose sequences and texts have about n elements."""
    kind, what = form
    if kind == Nodetype.NAME:
        own = store.types[what]
        return own(*(random_field(rng, store, inner, n) for _, inner in store.get_msgdef(what).fields))
    if kind == Nodetype.BASE:
        if what[0] == "string":
            return "ä" * n
        raw = np.frombuffer(rng.bytes(8), dtype=TYPES.get(what[0], what[0]))[0]
        return bool(int(rng.integers(2))) if what[0] == "bool" else raw.item()
    inner, count = what[0], what[1] if kind == Nodetype.ARRAY else n
    found = [random_field(rng, store, inner, n) for _ in range(count)]
    is_array = inner[0] == Nodetype.BASE and inner[1][0] != "string"
    return np.array(found, dtype=TYPES.get(inner[1][0], inner[1][0])) if is_array else found


def by_hand(content, place=""):
    """Yield the numbers of a message by the definition of a place."""
    if isinstance(content, bool | int | float | np.number):
        yield place or "data", float(content)
        return
    if isinstance(content, dict):
        parts = content.items()
    elif isinstance(content, list | tuple | np.ndarray):
        parts = enumerate(content) if len(content) <= 64 else ()
    else:
        parts = (
            (one.name, getattr(content, one.name))
            for one in (fields(content) if is_dataclass(content) else ())
            if one.default is MISSING
        )
    for key, value in parts:
        if not str(key).startswith("__"):
            yield from by_hand(value, f"{place}.{key}" if place else str(key))


def table(columns, n):
    found = {place: np.full(n, np.nan) for place in columns}
    for place, (rows, numbers) in columns.items():
        found[place][rows] = numbers
    return found


def one_by_one(contents):
    found = {}
    for k, content in enumerate(contents):
        for place, number in by_hand(content):
            found.setdefault(place, np.full(len(contents), np.nan))[k] = number
    return found


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("how", ["ros1", "little", "big", "both"])
@pytest.mark.parametrize("sizes", [(3,), (0,), (0, 1, 2, 3, 4, 5, 70)], ids=str)
def test_numbers_are_those_that_rosbags_decodes_message_by_message(name, how, sizes, monkeypatch):
    rng, is_cdr = np.random.default_rng(len(name)), how != "ros1"
    store = store_of(Stores.LATEST if is_cdr else Stores.ROS1_NOETIC)
    contents = [random_field(rng, store, (Nodetype.NAME, name), int(rng.choice(sizes))) for _ in range(8)]
    if is_cdr:
        orders = [how == "little" or (how == "both" and k % 3 > 0) for k in range(8)]
        messages = [
            bytes(store.serialize_cdr(one, name, little_endian=order))
            for one, order in zip(contents, orders, strict=True)
        ]
    else:
        messages = [bytes(store.serialize_ros1(one, name)) for one in contents]
    decoder = Decoder(store, name, is_cdr)
    asked, slow = [], decoder.decode
    monkeypatch.setattr(decoder, "decode", lambda *words: asked.append(1) or slow(*words))
    found, right = table(decoder(messages), 8), one_by_one([slow(one, name) for one in messages])
    assert found.keys() == right.keys()
    for place, numbers in right.items():
        np.testing.assert_array_equal(found[place], numbers, err_msg=place)
    if len(sizes) == 1 and how != "both" and name != "std_msgs/msg/Empty":
        assert len(asked) <= 2  # the others were one array


def test_a_layout_that_does_not_give_the_first_message_is_not_used(monkeypatch):
    store = store_of(Stores.LATEST)
    kind = store.types["geometry_msgs/msg/Vector3"]
    messages = [bytes(store.serialize_cdr(kind(x=1.0 + k, y=2.0, z=3.0), kind.__msgtype__)) for k in range(9)]
    monkeypatch.setitem(ros.SIZEMAP, "float64", 4)
    found = table(Decoder(store, kind.__msgtype__, is_cdr=True)(messages), 9)
    assert found["x"].tolist() == [1.0 + k for k in range(9)]
    assert found["z"].tolist() == [3.0] * 9


def test_a_message_that_was_cut_is_the_librarys_error():
    store = store_of(Stores.LATEST)
    kind = store.types["geometry_msgs/msg/Vector3"]
    whole = bytes(store.serialize_cdr(kind(x=1.0, y=2.0, z=3.0), kind.__msgtype__))
    with pytest.raises(Exception, match="Could not deserialize"):
        Decoder(store, kind.__msgtype__, is_cdr=True)([whole, whole, whole[:-5]])


@pytest.mark.parametrize("compression", ["NONE", "BZ2", "LZ4"])
def test_messages_of_a_bag_are_those_of_its_library_in_its_order(compression, tmp_path):
    store, path = store_of(Stores.ROS1_NOETIC), tmp_path / "run.bag"
    kind = store.types["std_msgs/msg/Float64"]
    writer = Writer(path)
    if compression != "NONE":
        writer.set_compression(Writer.CompressionFormat[compression])
    writer.chunk_threshold = 3000
    with writer as file:
        topics = []
        for k in range(900):
            if k in (0, 250, 500):  # a topic that begins within a chunk
                topics.append(file.add_connection(f"/t{k}", kind.__msgtype__, typestore=store))
            data = store.serialize_ros1(kind(data=float(k)), kind.__msgtype__)
            file.write(topics[k % len(topics)], 10**9 + 10**6 * (k - 5 * (k % 7)), data)
    with AnyReader([path]) as reader:
        right = [(one.topic, at, bytes(data)) for one, at, data in reader.messages()]
        assert [(one.topic, at, bytes(data)) for one, at, data in _of_chunks(reader.readers[0])] == right
        assert len({entry.chunk_pos for own in reader.readers[0].indexes.values() for entry in own}) > 5


CONTENTS = [
    {"a": 1, "b": {"c": [1.5, True, None]}, "__d": 4, "text": "x"},
    {"a": None, "b": {"c": [2, 3]}},
    {"b": 7, "e": list(range(65)), "a": {"0": 1}},
    5.0,
    [1, {"a": 2.0}],
    {"a": 10**20, "b": {"c": []}},
    "text",
    None,
]


def test_contents_of_any_kind_are_columns():
    rng = np.random.default_rng(4)
    contents = [CONTENTS[k] for k in rng.integers(len(CONTENTS), size=50)]
    found, right = table(columns_of(contents), 50), one_by_one(contents)
    assert found.keys() == right.keys()
    for place, numbers in right.items():
        np.testing.assert_array_equal(found[place], numbers, err_msg=place)


def test_messages_out_of_order_and_of_several_batches_are_put_in_order(monkeypatch):
    monkeypatch.setattr("octmip.recordings.readers.messages.BATCH", 7)
    instants = np.random.default_rng(2).permutation(50)
    other = lambda batch: columns_of([{"y": float(one)} for one in batch])  # noqa: E731
    own = lambda batch: columns_of([{"x": float(one)} for one in batch])  # noqa: E731
    messages = [("t", 10**9 * int(k), str(k).encode(), other if k in (20, 30) else own) for k in instants]
    opened = decoded("MCAP", messages)
    x, y = opened["t/x"], opened["t/y"]
    assert x.time.tolist() == y.time.tolist() == list(range(50))
    assert x.values[x.is_valid].tolist() == [k for k in range(50) if k not in (20, 30)]
    assert np.flatnonzero(y.is_valid).tolist() == y.values[y.is_valid].tolist() == [20, 30]


@pytest.mark.parametrize("is_chunked", [True, False])
def test_messages_of_mcap_are_those_of_its_library(is_chunked, tmp_path):
    store, path = store_of(Stores.LATEST), tmp_path / "run.mcap"
    vector, text = store.types["geometry_msgs/msg/Vector3"], store.generate_msgdef("geometry_msgs/msg/Vector3")[0]
    with path.open("wb") as stream:
        writer = McapWriter(stream, chunk_size=2000, use_chunking=is_chunked)
        writer.start()
        schema = writer.register_schema("geometry_msgs/Vector3", "ros2msg", text.encode())
        topics = [writer.register_channel("/json", "json", 0), writer.register_channel("/cdr", "cdr", schema)]
        for k in range(200):
            if k == 100:
                topics.append(writer.register_channel("/late", "protobuf", 0))
            data = store.serialize_cdr(vector(x=float(k), y=-1.0, z=0.5), vector.__msgtype__)
            body = [b'{"a": %d}' % k, bytes(data), b"\x08\x01"][k % len(topics)]
            writer.add_message(topics[k % len(topics)], 10**9 + 10**6 * (k - 5 * (k % 7)), body, 0)
        writer.finish()
    opened = recording(path)
    with path.open("rb") as stream:
        found = [(one.topic, at.log_time, at.data) for _, one, at in make_reader(stream).iter_messages()]
    assert opened.channels == ("/json/a", "/cdr/x", "/cdr/y", "/cdr/z")
    x = functools.partial(store.deserialize_cdr, typename=vector.__msgtype__)
    for name, value in (("/json/a", lambda data: json.loads(data)["a"]), ("/cdr/x", lambda data: x(data).x)):
        right = [(at, value(data)) for topic, at, data in found if name.startswith(topic)]
        assert opened[name].values.tolist() == [number for _, number in right]
        assert opened[name].time == pytest.approx([(at - found[0][1]) / 1e9 for at, _ in right], abs=1e-9)


@pytest.mark.parametrize("odd", [b'"text"', b"[1, 2]", b"5", b'{"a": 1}, {"a": 2}', b"{", b"\xff\xfe5\x00"])
def test_json_is_read_all_at_once_where_it_may_be(odd):
    messages = [b'{"a": 1.5}', odd, b'{"a": NaN, "b": true}']
    try:
        right = one_by_one([json.loads(one) for one in messages])
    except ValueError:
        with pytest.raises(json.JSONDecodeError):
            _json(messages)
        return
    found = table(_json(messages), 3)
    assert found.keys() == right.keys()
    for place, numbers in right.items():
        np.testing.assert_array_equal(found[place], numbers)


def test_an_index_may_name_the_connection_before_a_message_and_nothing_else():
    def record(kind, data):
        header = struct.pack("<I", 4) + b"op=" + bytes([kind])
        return struct.pack("<I", len(header)) + header + struct.pack("<I", len(data)) + data

    for first, is_right in ((7, True), (5, False)):
        content = record(first, b"about") + record(2, b"message")
        chunk = SimpleNamespace(datapos=0, datasize=len(content), decompressor=bytes)
        connection = SimpleNamespace(id=0)
        bag = SimpleNamespace(bio=io.BytesIO(content), chunks={0: chunk}, connections=[connection])
        bag.indexes = {0: [(5, 0, 0)]}
        if is_right:
            assert list(_of_chunks(bag)) == [(connection, 5, b"message")]
        else:
            with pytest.raises(DataError, match="names what is no message"):
                list(_of_chunks(bag))
