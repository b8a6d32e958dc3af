"""DataFlash of ArduPilot (.bin) by pymavlink: messages of fields, in order of TimeUS.

The unit is the log's own: pymavlink applies the factors of the formats c, C, e, E and L, and writes the log's other
multipliers before the unit ("0.01 m"), without multiplying. Number and unit belong together so, and octmip converts.

pymavlink knows formats, units and instances; its `recv_msg` takes the next header of a known message behind the one
before, and so is every message found here, all at once.
"""

import contextlib
import functools
import os
import struct
from array import array
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from octmip.errors import DataError, needed_by
from octmip.recordings.readers.messages import MICRO, Rows, Topic, field_of, of_topics
from octmip.recordings.recording import Recording

os.environ.setdefault("PYMAVLINK_FAST_INDEX", "0")  # the fast index prints past Python on standard output
with needed_by("a recording of DataFlash"):
    from pymavlink.DFReader import FORMAT_TO_STRUCT, DFReader_binary

TIME, HEAD, FORMAT = "TimeUS", 3, 0x80
ABOUT = frozenset({"FMT", "FMTU", "UNIT", "MULT", "PARM", "MSG", "FILE"})
"""Messages that say what others mean, and those of text."""
GARBAGE = 528
"""Bytes of which pymavlink expects no message at the end of a log once it could not unpack one."""


class _Log(DFReader_binary):  # type: ignore[misc]
    """A log without its clock of GPS, for which every message would be unpacked, and without the list of messages."""

    def init_clock(self) -> None:
        self.offsets: list[list[int]] = []
        self._rewind(keep_messages=True)


def read(path: Path) -> Recording:
    """Return the fields of a log as MESSAGE/FIELD, of an instance as MESSAGE[1]/FIELD."""
    content = np.memmap(path, dtype=np.uint8, mode="r")
    with contextlib.closing(_Log(str(path))) as log:
        places = _messages(log.data_map, log.formats)
        size = log.formats[FORMAT].len
        if len({content[k : k + size].tobytes() for k in places.get(FORMAT, ())}) > len(log.formats):
            raise DataError(f"{path}: two formats of one message; expected one; split the log between them")
        rows: dict[str, tuple[Any, Rows]] = {}
        for number in sorted(places):
            form, own = log.formats[number], places[number]
            if form.name in ABOUT or TIME not in form.columns:
                continue
            if form.instance_field is None:
                rows[form.name] = form, own
                continue
            raw = _field(content, form, own, form.instance_field)[1]
            for value in dict.fromkeys(raw.tolist()):
                part = own[raw == value]
                log.offset = int(part[0])
                name = f"{form.name}[{getattr(log.recv_msg(), form.instance_field)}]"
                rows[name] = form, np.sort(np.append(part, rows[name][1])) if name in rows else part
    topics = dict[str, Topic]()
    for name, (form, own) in rows.items():
        names = [field for field in form.columns if field not in (TIME, form.instance_field)]
        stamps = np.asarray(_field(content, form, own, TIME)[1], dtype=np.int64)
        topics[name] = stamps, names, functools.partial(_field, content, form, own)
    return of_topics("DataFlash", topics, MICRO)


def _messages(content: Any, forms: Mapping[int, Any]) -> dict[int, Rows]:
    """Return where messages begin, by kind, as `recv_msg` finds them: the next head of a known kind behind the last."""
    is_whole = {number: struct.calcsize(form.msg_struct) == form.len - HEAD for number, form in forms.items()}
    found, at = {number: array("q") for number, whole in is_whole.items() if whole}, 0
    while (at := content.find(b"\xa3\x95", at)) >= 0 and at + HEAD <= len(content):
        number = content[at + 2]
        if number in found:
            size = forms[number].len
            if at + size > len(content):
                break
            found[number].append(at)
            at += size
        elif number in forms:  # what it cannot unpack it searches for others
            if at + HEAD + GARBAGE > len(content):
                break
            at += HEAD
        else:
            at += 1
    return {number: np.array(own, dtype=np.int64) for number, own in found.items() if own}


def _field(content: NDArray[np.uint8], form: Any, at: Rows, field: str) -> tuple[str, NDArray[Any]]:
    """Return unit and values (n,) of a field of messages of one format as pymavlink gives them, (n, 32) of an array."""
    k = form.columns.index(field)
    codes = [FORMAT_TO_STRUCT[letter][0] for letter in form.msg_fmts]
    begin, is_text = HEAD + struct.calcsize("<" + "".join(codes[:k])), codes[k][:-1].isdigit()
    kind = "(32,)<i2" if form.msg_fmts[k] == "a" else f"S{codes[k][:-1]}" if is_text else "<" + codes[k]
    values, factor = field_of(content, at, begin, kind), form.msg_mults[k]
    return form.get_unit(field) or "", values if factor is None else values / (1.0 / factor)
