"""Messages of DataFlash that are found all at once are those that pymavlink reads one by one."""

import struct
from types import SimpleNamespace

import numpy as np
import pytest
from pymavlink.DFReader import DFReader_binary

from octmip.errors import DataError
from octmip.recordings import recording

FIELDS = {"a": "64s", "n": "4s", "N": "16s", "Z": "64s", "c": "h", "C": "H", "e": "i", "E": "I", "L": "i", "M": "b"}
FIELDS |= {"b": "b", "B": "B", "g": "e", "h": "h", "H": "H", "i": "i", "I": "I", "f": "f", "d": "d", "q": "q", "Q": "Q"}
KINDS = {
    150: ("ALL", "QbBghHiIfdqQ", None),
    155: ("MORE", "QcCeELM", None),
    151: ("GPS", "QBLLe", 1),
    152: ("TXT", "QZNna", None),
}
KINDS |= {0xA3: ("ODD", "QH", None), 153: ("NAME", "QNf", 1), 154: ("GONE", "BBB", None)}


def columns_of(fields):
    if fields == "QBNN":
        return ["TimeUS", "FmtType", "UnitIds", "MultIds"]
    return ["TimeUS" if letter == "Q" and not k else f"F{k}" for k, letter in enumerate(fields)]


def form(number, name, fields, size=None):
    length = size or 3 + struct.calcsize("<" + "".join(FIELDS[letter] for letter in fields))
    body = struct.pack(
        "<BB4s16s64s", number, length, name.encode(), fields.encode(), ",".join(columns_of(fields)).encode()
    )
    return b"\xa3\x95\x80" + body


def log_of(rng, n, spoil=None):
    """Return messages of all kinds with random bytes in their fields; `spoil` may put others between them."""
    found = form(128, "FMT", "BBnNZ") + form(131, "FMTU", "QBNN")
    found += b"".join(form(number, name, fields) for number, (name, fields, _) in KINDS.items())
    for number, (_, fields, instance) in KINDS.items():
        if instance is not None:
            units = "".join("#" if k == instance else "-" for k in range(len(fields))).encode()
            found += b"\xa3\x95\x83" + struct.pack("<QB16s16s", 0, number, units, b"-" * len(fields))
    for k in range(n):
        number = int(rng.choice(list(KINDS)))
        _, fields, instance = KINDS[number]
        body = bytearray(rng.bytes(struct.calcsize("<" + "".join(FIELDS[letter] for letter in fields))))
        if fields[0] == "Q":
            body[:8] = struct.pack("<Q", 10**6 + 1000 * k)
        if instance is not None:
            body[8 : 8 + struct.calcsize(FIELDS[fields[1]])] = (
                bytes([k % 3]) if fields[1] == "B" else rng.choice([b"left", b"right"]).ljust(16, b"\0")
            )
        found += bytes([0xA3, 0x95, number]) + bytes(body)
        found += spoil(rng, k) if spoil else b""
    return found


def one_by_one(path):
    """Return times and values of every field of numbers, message by message."""
    found, reader = {}, DFReader_binary(str(path))
    while (message := reader.recv_msg()) is not None:
        own = message.fmt
        if own.name in ("FMT", "FMTU") or "TimeUS" not in own.columns:
            continue
        name = own.name if own.instance_field is None else f"{own.name}[{getattr(message, own.instance_field)}]"
        for column in own.columns:
            if column not in ("TimeUS", own.instance_field):
                found.setdefault(f"{name}/{column}", []).append((message.TimeUS, getattr(message, column)))
    reader.close()
    start = min((rows[0][0] for rows in found.values()), default=0)
    return start, {name: rows for name, rows in found.items() if isinstance(rows[0][1], int | float)}


def garbage(rng, k):
    return rng.bytes(int(rng.integers(1, 40))) if k % 11 == 3 else b""


def heads(rng, k):
    """Return what looks like a message's beginning and is none."""
    return b"\xa3\x95" + bytes([int(rng.choice([0xA3, 150, 7]))]) * int(rng.integers(3)) if k % 7 == 5 else b""


CASES = {
    "whole": (None, lambda content: content),
    "garbage between": (garbage, lambda content: content),
    "false heads": (heads, lambda content: content),
    "zeros at the end": (None, lambda content: content + bytes(600)),
    "a message cut": (None, lambda content: content[:-5]),
    "a head cut": (garbage, lambda content: content + b"\xa3\x95"),
    "a format that does not fit": (None, lambda content: form(160, "BAD", "QH", 40) + content + b"\xa3\x95\xa0" * 30),
    "it ends the log": (
        None,
        lambda content: form(160, "BAD", "QH", 40) + content[:-40] + b"\xa3\x95\xa0" * 9 + content[-40:],
    ),
    "bytes before": (None, lambda content: form(128, "FMT", "BBnNZ") + bytes(9) + content),
    "one message": (None, lambda content: content[: 89 * 8]),
}


@pytest.mark.parametrize("seed", [1, 2])
@pytest.mark.parametrize("case", CASES)
def test_messages_are_those_that_pymavlink_reads_one_by_one(case, seed, tmp_path, monkeypatch):
    as_it_is = lambda name, unit, time, values: SimpleNamespace(time=time, values=values)  # noqa: E731
    monkeypatch.setattr("octmip.recordings.readers.messages.Channel", as_it_is)  # garbage has times in any order
    spoil, change = CASES[case]
    path = tmp_path / "run.bin"
    path.write_bytes(change(log_of(np.random.default_rng(seed), 400, spoil)))
    start, right = one_by_one(path)
    if not right:
        with pytest.raises(DataError, match="holds no channel of numbers"):
            recording(path)
        return
    opened = recording(path)
    numbers = [name for name in opened.channels if not name.startswith("TXT")]
    assert set(numbers) == set(right)
    for name, rows in right.items():
        times, values = (np.array(part, dtype=object) for part in zip(*rows, strict=True))
        channel = opened[name]
        np.testing.assert_array_equal(channel.values, values.astype(float), err_msg=name)
        is_time = times < 2**62  # garbage may be more than 292,000 years
        assert channel.time[is_time] == pytest.approx((times - start)[is_time].astype(float) / 1e6, rel=1e-12)
    if case == "whole":
        assert len(numbers) == 11 + 6 + 9 + 1 + 2


@pytest.mark.parametrize(("field", "said"), [("F1", "texts"), ("F4", r"values of shape \(\d+, 32\)")])
def test_texts_and_arrays_are_no_channels(field, said, tmp_path):
    (tmp_path / "run.bin").write_bytes(log_of(np.random.default_rng(1), 50))
    with pytest.raises(DataError, match=f"TXT/{field}' holds {said}"):
        recording(tmp_path / "run.bin")[f"TXT/{field}"]


def test_a_format_that_is_said_otherwise_a_second_time_is_refused(tmp_path):
    content = log_of(np.random.default_rng(1), 20) + form(150, "ALL", "QQ")
    (tmp_path / "run.bin").write_bytes(content)
    with pytest.raises(DataError, match=r"run\.bin: two formats of one message; expected one; split the log"):
        recording(tmp_path / "run.bin")
